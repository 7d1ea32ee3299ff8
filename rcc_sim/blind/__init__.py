"""Data whose effect is withheld: made, diagnosed, scored."""
