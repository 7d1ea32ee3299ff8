"""What of the found is asserted, what ties with it, and what must stay in doubt."""
