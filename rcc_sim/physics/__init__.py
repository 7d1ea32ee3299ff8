"""Numbers in, numbers out: no files, no tables, no text."""
