"""Which effects may be behind a gap, and what a cause is once it is found."""
