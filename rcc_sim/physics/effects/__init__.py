"""The catalogue of effects: one file each, collected by id."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from rcc_sim.physics.effect import Effect

EFFECTS: dict[str, Effect] = {
    path.stem: import_module(f"{__name__}.{path.stem}").EFFECT
    for path in sorted(Path(__file__).parent.glob("[a-z]*.py"))
}
"""Id -> effect, in alphabetical order."""
