"""One log beside the model: what any figures leave of each channel it measured."""
