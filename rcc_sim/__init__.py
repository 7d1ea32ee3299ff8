"""Scaled vehicles, their energy, and why simulation and reality part."""

__version__ = "0.1.0"
