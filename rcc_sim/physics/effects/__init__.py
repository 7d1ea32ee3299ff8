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


def nil_of(key: str, known: Mapping[str, Effect]) -> float:
    """Value of a figure at which its effect vanishes; infinite of a limit.

    ``known`` are all effects, a user's own among them.
    """
    _, name, param = key.split(".")
    return known[name].param(param).neutral if name in known else 0.0


def neutral_of(key: str, known: Mapping[str, Effect]) -> float:
    """The same as a number from which a figure can be counted: 0 of a limit."""
    nil = nil_of(key, known)
    return nil if isfinite(nil) else 0.0
