"""What a trace says: where the energy went."""
