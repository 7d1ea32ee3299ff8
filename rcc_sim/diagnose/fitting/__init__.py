"""Figures that a fit may move, the logs they are fitted to, and the way down."""
