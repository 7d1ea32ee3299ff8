"""Vehicle and cycle in, trace and ledger out."""
