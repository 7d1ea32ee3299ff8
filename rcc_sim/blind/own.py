"""A base to draw around, from a vehicle file."""

from __future__ import annotations

from rcc_sim.blind.bases import Base


def base_of(name: str) -> Base:
    """Return the base that a vehicle file describes."""
    raise NotImplementedError(name)
