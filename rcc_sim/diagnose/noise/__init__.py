"""What is left when the model is right: whitened, and how likely."""
