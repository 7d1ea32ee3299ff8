"""Evidence of many logs added up."""
