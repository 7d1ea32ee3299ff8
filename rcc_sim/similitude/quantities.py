"""A vehicle's figures by the paper's letters, and products of their powers."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import NamedTuple

from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.similitude.dimensional import Exponents
from rcc_sim.units import G


class Interval(NamedTuple):
    """A number and the ends between which it may lie."""

    value: float
    low: float
    high: float

    def over(self, other: Interval) -> Interval:
        """Return the ratio of two independent positive numbers."""
        return Interval(
            _ratio(self.value, other.value),
            _ratio(self.low, other.high),
            _ratio(self.high, other.low),
        )

    def times(self, factor: float) -> Interval:
        """Return it multiplied by a positive number."""
        return Interval(self.value * factor, self.low * factor, self.high * factor)

    def holds(self, number: float) -> bool:
        """Tell whether a number lies between the ends."""
        return self.low <= number <= self.high


KEYS: dict[str, tuple[str, ...]] = {
    "m": ("body.mass_kg",),
    "I_z": ("body.yaw_inertia_kgm2",),
    "l_F": ("body.cg_to_front_axle_m",),
    "l_R": ("body.cg_to_rear_axle_m",),
    "h_cg": ("body.cg_height_m",),
    "w": ("body.track_width_m",),
    "C_F": ("tyres.front_cornering_stiffness_n_per_rad",),
    "C_R": ("tyres.rear_cornering_stiffness_n_per_rad",),
    "r_w": ("tyres.radius_m",),
    "mu": (
        "effects.tyre_saturation.friction_coefficient",
        "tyres.friction_coefficient",
    ),
    "N_d": ("drivetrain.gear_ratio",),
    "J": ("effects.rotor_inertia.inertia_kgm2",),
    "B": ("effects.drivetrain_damping.damping_nms_per_rad",),
    "eta": ("effects.motor_efficiency.scale",),
    "T_C": ("effects.drivetrain_friction.torque_nm",),
    "C_rr": ("effects.rolling_resistance.coefficient",),
    "C_dA": ("effects.aerodynamic_drag.drag_area_m2",),
    "rho": ("effects.aerodynamic_drag.air_density_kg_per_m3",),
    "F_0": ("effects.road_load.a_n",),
    "F_1": ("effects.road_load.b_n_s_per_m",),
    "F_2": ("effects.road_load.c_n_s2_per_m2",),
    "P_aux": ("effects.auxiliary_load.power_w",),
}
"""Symbol -> key of the vehicle file; the first that is stated."""

CHANGED_BY = (
    "payload",
    "cg_shift",
    "yaw_inertia",
    "front_cornering_stiffness",
    "rear_cornering_stiffness",
    "wheel_radius",
)
"""Effects that alter a figure of the file; similitude takes the file's figure."""


class Figures(NamedTuple):
    """What a vehicle states, by symbol.

    Attributes
    ----------
    name : str
        The vehicle's.
    known : mapping of str to Interval
        Symbol -> number with its ends; the wheelbase l and gravity g among them.
    guesses : frozenset of str
        Symbols whose figure is a guess by its own source.
    """

    name: str
    known: Mapping[str, Interval]
    guesses: frozenset[str]

    def missing(self, exponents: Exponents) -> list[str]:
        """Return the symbols of a product that the vehicle does not state."""
        return [symbol for symbol in exponents if symbol not in self.known]


def figures_of(vehicle: Vehicle) -> Figures:
    """Return a vehicle's figures by symbol."""
    stated = vehicle.figures()
    if isinstance(vehicle.effects.get("motor_efficiency", {}).get("map"), str):
        stated.pop("effects.motor_efficiency.scale", None)  # a factor on the map, not η
    known: dict[str, Interval] = {"g": Interval(G, G, G)}
    guesses = set()
    for symbol, keys in KEYS.items():
        figure = next((stated[key] for key in keys if key in stated), None)
        if figure is not None:
            known[symbol] = _interval(figure)
            if figure.is_guess:
                guesses.add(symbol)
    if "rho" not in known:
        rho = EFFECTS["aerodynamic_drag"].neutral["air_density_kg_per_m3"]
        known["rho"] = Interval(rho, rho, rho)
    front, rear = known["l_F"], known["l_R"]
    known["l"] = Interval(*(f + r for f, r in zip(front, rear, strict=True)))
    if {"l_F", "l_R"} & guesses:
        guesses.add("l")
    return Figures(vehicle.name, known, frozenset(guesses))


def _interval(figure: Figure) -> Interval:
    low, high = figure.interval
    if figure.value >= 0:
        low = max(low, 0.0)
    return Interval(figure.value, low, high)


def product(figures: Figures, exponents: Exponents) -> Interval | None:
    """Return a product of powers of a vehicle's figures; None if one is missing.

    With the others held, a product of powers rises or falls with each figure all the
    way, so that it is least and greatest where every figure is at one of its ends.
    The wheelbase is l_F + l_R, which are the figures that vary.
    """
    if figures.missing(exponents):
        return None
    free = {s for s in exponents if s != "l"}
    if "l" in exponents:
        free |= {"l_F", "l_R"}
    known = figures.known
    order = sorted(free)
    ends = [sorted({known[s].low, known[s].high}) for s in order]
    corners = [
        _value(exponents, dict(zip(order, corner, strict=True)))
        for corner in itertools.product(*ends)
    ]
    value = _value(exponents, {s: known[s].value for s in order})
    return Interval(value, min(corners), max(corners))


def _value(exponents: Exponents, numbers: Mapping[str, float]) -> float:
    result = 1.0
    for symbol, e in exponents.items():
        x = numbers["l_F"] + numbers["l_R"] if symbol == "l" else numbers[symbol]
        if x == 0 and e < 0:
            return math.inf
        if x < 0 and e.denominator != 1:
            return math.nan
        result *= x ** int(e) if e.denominator == 1 else x ** float(e)
    return result


def _ratio(above: float, below: float) -> float:
    if below == 0:
        return math.nan if above == 0 else math.inf
    return above / below
