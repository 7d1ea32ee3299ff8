"""The catalogue of effects: one file each, collected by id."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from math import isfinite
from pathlib import Path

from rcc_sim.physics.effect import Effect

EFFECTS: dict[str, Effect] = {
    path.stem: import_module(f"{__name__}.{path.stem}").EFFECT
    for path in sorted(Path(__file__).parent.glob("[a-z]*.py"))
}
"""Id -> effect, in alphabetical order."""


def neutral_of(key: str, known: Mapping[str, Effect]) -> float:
    """Value of a figure at which its effect vanishes; 0 where that is infinite.

    ``known`` are all effects, a user's own among them.
    """
    _, name, param = key.split(".")
    neutral = known[name].param(param).neutral if name in known else 0.0
    return neutral if isfinite(neutral) else 0.0
