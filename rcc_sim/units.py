"""Constants, and the unit suffixes of edge names (files, columns, JSON keys)."""

from __future__ import annotations

G = 9.80665
"""Standard gravity. [m/s²]"""

RHO_AIR = 1.2
"""Density of air where none is given. [kg/m³]"""

J_PER_WH = 3600.0
"""Joules in a watt-hour. [J/Wh]"""

SUFFIXES: dict[str, str] = {
    "n_s2_per_m2": "N s²/m²",
    "n_s_per_m": "N s/m",
    "nms_per_rad": "N m s/rad",
    "n_per_rad": "N/rad",
    "as_per_rad": "A s/rad",
    "a_per_rad": "A/rad",
    "kg_per_m3": "kg/m³",
    "rpm_per_v": "rpm/V",
    "wh_per_km": "Wh/km",
    "kgm2": "kg m²",
    "mps2": "m/s²",
    "radps": "rad/s",
    "percent": "%",
    "erpm": "ERPM",
    "per_h": "1/h",
    "degc": "°C",
    "ohm": "Ω",
    "mps": "m/s",
    "rad": "rad",
    "nm": "N m",
    "wh": "Wh",
    "ah": "A h",
    "wb": "Wb",
    "hz": "Hz",
    "kg": "kg",
    "m2": "m²",
    "m": "m",
    "s": "s",
    "n": "N",
    "w": "W",
    "j": "J",
    "v": "V",
    "a": "A",
    "h": "H",
}
"""Suffix of an edge name -> the unit as it is written for people; longest first."""


def unit_of(name: str) -> str:
    """Return the unit that an edge name ends in, or "1" if it carries none.

    >>> unit_of("yaw_inertia_kgm2"), unit_of("gear_ratio")
    ('kg m²', '1')
    """
    for suffix, unit in SUFFIXES.items():
        if name.endswith("_" + suffix):
            return unit
    return "1"
