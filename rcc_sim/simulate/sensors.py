"""What the sensors make of a run: effects that touch the log alone."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.own_effects import sensed_by
from rcc_sim.definitions.vehicle import Vehicle

Array = NDArray[np.float64]


def sensed_columns(
    vehicle: Vehicle, columns: Mapping[str, Array], *, imposed: bool = False
) -> dict[str, Array]:
    """Return the columns as the vehicle's sensors log them.

    Each sensor effect that the vehicle has acts in turn; at its neutral value it
    leaves the columns as they are, to the last bit. The energy ledger is the car's, not
    the sensors', and stays. A drive that is ``imposed`` has the clock of its speed.
    """
    seen = dict(columns)
    for name, given in vehicle.effects.items():
        effect = vehicle.known[name]
        if not effect.sensor:
            continue
        values = effect.neutral | {
            key: figure.value
            for key, figure in given.items()
            if isinstance(figure, Figure)
        }
        if values == effect.neutral:
            continue
        if name in vehicle.own:
            seen |= sensed_by(vehicle.own[name], seen, values.values())
            continue
        module = import_module(f"rcc_sim.physics.effects.{name}")
        acting = tuple(values.values())
        if imposed and hasattr(module, "behind_speed"):
            acting = module.behind_speed(*acting)
        seen |= module.sensed(seen, seen["time_s"], *acting)
    return seen
