"""Causes that vary over a drive, and what is left of it that none explains."""
