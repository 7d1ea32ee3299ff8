"""What people call the columns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rcc_sim.report.text import figures
from rcc_sim.units import SUFFIXES, unit_of

TITLES = {
    "time_s": "Time",
    "since_braking_s": "Time since braking",
    "since_standing_s": "Time since standing",
    "distance_m": "Distance",
    "speed_mps": "Speed",
    "speed_ref_mps": "Speed reference",
    "throttle": "Throttle",
    "steer_cmd_rad": "Steering command",
    "motor_current_a": "Motor current",
    "motor_torque_nm": "Motor torque",
    "motor_speed_radps": "Motor speed",
    "battery_power_w": "Battery power",
    "battery_voltage_v": "Battery voltage",
    "battery_current_a": "Battery current",
    "aux_power_w": "Auxiliary power",
    "headwind_mps": "Headwind",
    "accel_x_mps2": "Acceleration",
    "accel_y_mps2": "Lateral acceleration",
    "yaw_rate_radps": "Yaw rate",
    "x_m": "Way along x",
    "y_m": "Lateral place",
    "yaw_rad": "Heading",
    "turn_rate_radps": "Heading's rate",
    "slope": "Slope",
    "elevation_m": "Elevation",
    "battery_energy_wh": "Energy from the battery",
}
"""Column -> title, in the order in which reports draw them."""


WAYS = {
    "drag": "a drag",
    "power": "a power",
    "mass": "a mass",
    "steer": "an angle of the wheels",
    "grip": "another grip of the tyres",
    "efficiency": "an efficiency",
    "feed": "an infeed to the battery (or a meter off by it)",
}
"""Way of acting -> what it is."""

MAP = "a measured map states that: effects.motor_efficiency.map"
"""What is said of an efficiency that is no constant."""

LADEN = "a log from stop to stop tells it as payload"
"""What is said of a mass that changes."""

KNOWN = 2.0
"""Times its least sd up to which a course is known well enough to be told."""


def title_of(column: str) -> str:
    """Return what to call a column: its own title, else its name without the unit.

    >>> title_of("yaw_rate_radps"), title_of("tyre_temperature_degc")
    ('Yaw rate', 'Tyre temperature')
    """
    if column in TITLES:
        return TITLES[column]
    ends = (s for s in SUFFIXES if column.endswith("_" + s))
    plain = column.removesuffix("_" + next(ends, "")).replace("_", " ").strip()
    return plain[:1].upper() + plain[1:]


def way_of(acts_as: str, course: Mapping[str, Any] | None = None) -> str:
    """Return how something unknown acts, in words; an effect's own id for itself.

    With its ``course``, from what to what, where that is known as well as anywhere; not
    of a grip, of which a small change tells little of a large one.

    >>> way_of("steer"), way_of("rolling_resistance")
    ('an angle of the wheels', 'a changing rolling_resistance')
    >>> course = {"value": [-50.0, 800.0, 0.0], "sd": [30.0, 400.0, 20.0]}
    >>> way_of("mass", {"figure": "effects.payload.mass_kg", **course})
    'a mass (−50 to 0 kg beside what is stated)'
    >>> way_of("grip", {"figure": "effects.tyre_saturation.friction_coefficient"})
    'another grip of the tyres'
    """
    told = WAYS.get(acts_as, f"a changing {acts_as}")
    if not course or acts_as == "grip":
        return told
    pairs = list(zip(course["value"], course["sd"], strict=True))
    least = KNOWN * min(sd for _, sd in pairs)
    known = [x for x, sd in pairs if sd <= least]
    unit = unit_of(str(course["figure"]))
    span = f"{figures(min(known))} to {figures(max(known))}"
    return f"{told} ({span}{f' {unit}' * (unit != '1')} beside what is stated)"


def mend_of(acts_as: str, follows: str) -> str:
    """Return what would state what is unknown, where something does.

    >>> mend_of("drag", "time_s"), mend_of("efficiency", "time_s")
    ('', '')
    """
    if acts_as == "mass":
        return LADEN
    return MAP if acts_as == "efficiency" and follows != "time_s" else ""


def labelled(column: str) -> str:
    """Return a column's title with its unit in brackets.

    >>> labelled("battery_power_w"), labelled("throttle")
    ('Battery power [W]', 'Throttle')
    """
    unit = unit_of(column)
    return title_of(column) + (f" [{unit}]" if unit != "1" else "")


def in_order(columns: list[str]) -> list[str]:
    """Return columns in the order of TITLES, unknown ones after."""
    known = list(TITLES)
    return sorted(columns, key=lambda c: known.index(c) if c in known else len(known))
