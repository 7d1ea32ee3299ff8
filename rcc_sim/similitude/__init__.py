"""When two vehicles are similar, and what carries over from one to the other."""
