"""A winding road, and what sensors see of a car on it that is not always the same."""

import numpy as np


def winding(swing=3.0, period=9.0, seconds=300.0):
    """Return a drive of bends at 14 m/s, faster and slower by the swing [m/s]."""
    t = np.arange(0.0, seconds, 0.1)
    return {
        "time_s": t,
        "speed_mps": 14 + swing * np.sin(t / period),
        "steer_cmd_rad": 0.03 * np.sin(t / 3.1),
    }


def seen_of(usual, other, where, sizes, rng):
    """Return channels, some rows of them another car's, with noise of these sizes."""
    return {
        c: np.where(where, other[c], usual[c]) + size * rng.normal(size=len(where))
        for c, size in sizes.items()
    }
