"""What the runs of a part came to: figures by edge name, and what is wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.errors import LedgerError
from rcc_sim.physics.ledger import CLOSES, LEAST, left_open
from rcc_sim.units import J_PER_WH

Array = NDArray[np.float64]

LIMITS = {
    "max_speed_mps": "v_max",
    "max_battery_power_w": "P_max",
    "min_battery_power_w": "P_min",
    "max_battery_current_a": "i_max",
    "max_motor_torque_nm": "tau_max",
    "min_motor_torque_nm": "tau_min",
    "max_motor_current_a": "i_q_max",
    "max_accel_x_mps2": "a_x_max",
    "min_accel_x_mps2": "a_x_min",
    "max_accel_y_mps2": "a_y_max",
    "max_yaw_rate_radps": "r_max",
    "torque_short_s": "short",
    "speed_limited_s": "limited",
    "outside_map_s": "outside",
}
"""Column -> what the kernel calls it; peaks are those of the rows of a trace."""


@dataclass(frozen=True)
class Outcome:
    """What the runs of a part came to: sums and peaks, and the ledgers."""

    out: Any
    ends: Any


def figures(outcome: Outcome) -> dict[str, Array]:
    """Return the figures of each run: energy, distance, ledger, peaks."""
    out, ends = outcome.out, outcome.ends
    energy = (out["E"] - ends["battery_resistance"]) / J_PER_WH
    with np.errstate(divide="ignore", invalid="ignore"):
        per_km = np.where(out["s"] > 0, energy / (out["s"] / 1000), np.nan)
    return {
        "energy_wh": energy,
        "distance_m": out["s"],
        "duration_s": out["t"],
        "wh_per_km": per_km,
        **{f"energy_{sink}_wh": ends[sink] / J_PER_WH for sink in ends.dtype.names},
        **{name: out[symbol] for name, symbol in LIMITS.items()},
        "ledger_left_open": _left_open(outcome),
    }


def faults(errors: Sequence[str | None], outcome: Outcome) -> list[str | None]:
    """Return what is wrong with each run, now that it was done; None if nothing."""
    found = list(errors)
    out, open_ = outcome.out, _left_open(outcome)
    wrong = ~(np.abs(open_) <= CLOSES) | (out["P_over"] > 1)
    for i in np.flatnonzero(wrong):
        found[i] = found[i] or _fault(out[i], outcome.ends[i])
    return found


def _fault(result: Any, end: Any) -> str:
    if result["P_over"] > 1:
        return (
            f"effects.battery_resistance: the drive asks for {result['P_over']:.2g} "
            "times the most power that the battery can give"
        )
    ledger = {name: float(end[name]) for name in end.dtype.names}
    try:
        left_open("run", float(result["E"]), ledger, float(result["E_abs"]))
    except LedgerError as error:
        return str(error).removeprefix("run: ")
    return "the energy ledger does not close"


def _left_open(outcome: Outcome) -> Array:
    """Return what each ledger leaves open, as `left_open` has it."""
    lines = np.array([outcome.ends[name] for name in outcome.ends.dtype.names])
    through = np.maximum(outcome.out["E_abs"], np.abs(lines).sum(axis=0))
    left = outcome.out["E"] - lines.sum(axis=0)
    return np.asarray(left / np.maximum(through, LEAST))
