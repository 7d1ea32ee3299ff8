"""Which unmodelled effect parts simulation and reality, how much, and how sure."""
