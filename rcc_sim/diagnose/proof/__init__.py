"""Whether the gap shrinks where no fit has seen it."""
