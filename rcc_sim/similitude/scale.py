"""What a quantity of one vehicle is at the size of another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from typing import Any, Protocol

from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.vehicle import Vehicle, build
from rcc_sim.errors import InputError, require_positive
from rcc_sim.similitude import dimensional as dim
from rcc_sim.similitude.dimensional import REPEATING, Dimension, dimension_of
from rcc_sim.similitude.quantities import (
    Figures,
    Interval,
    figures_of,
    product,
)
from rcc_sim.units import SUFFIXES

QUANTITIES: dict[str, Dimension] = {
    "length": dim.LENGTH,
    "distance": dim.LENGTH,
    "speed": dim.SPEED,
    "time": dim.TIME,
    "frequency": dim.RATE,
    "acceleration": dim.ACCELERATION,
    "mass": dim.MASS,
    "force": dim.FORCE,
    "power": dim.POWER,
    "energy": dim.ENERGY,
    "energy_per_distance": dim.FORCE,
    "torque": dim.ENERGY,
    "yaw_rate": dim.RATE,
    "yaw_acceleration": Dimension(0, 0, -2),
    "steer": dim.NONE,
    "yaw_inertia": dim.INERTIA,
    "cornering_stiffness": dim.FORCE,
    "curvature": Dimension(0, -1, 0),
    "area": Dimension(0, 2, 0),
    "shaft_inertia": dim.INERTIA,
    "shaft_damping": dim.DAMPING,
}
"""Quantity -> dimension; each scales as the π-groups say."""

SHAFT: dict[str, tuple[Dimension, int]] = {
    "motor_torque": (dim.FORCE, 1),
    "motor_speed": (dim.SPEED, -1),
}
"""Quantities of the shaft -> what they are at the wheel, and the power of r_w/N_d.

The force at the wheels and the speed of the vehicle are what similar vehicles share;
at the shaft they show through each vehicle's own wheel radius and gear.
"""


class Scalable(Protocol):
    """A number, an array or a column of a data frame."""

    def __mul__(self, other: float, /) -> Any:
        """Return it multiplied."""


@dataclass(frozen=True)
class Scales:
    """Factors that turn a quantity of the second vehicle into that of the first.

    Parameters
    ----------
    first, second : Figures
        Of the two vehicles.
    same : bool
        Whether they are one vehicle: every factor is then exactly 1.
    """

    first: Figures
    second: Figures
    same: bool = False

    @classmethod
    def between(cls, first: Vehicle, second: Vehicle) -> Scales:
        """Return the scales to the first vehicle from the second."""
        return cls(figures_of(first), figures_of(second), same=first == second)

    def reversed(self) -> Scales:
        """Return the scales the other way."""
        return Scales(self.second, self.first, self.same)

    def factor(self, dimension: Dimension, lever: int = 0) -> Interval:
        r"""Return the factor of a dimension.

        .. math:: x_1 / x_2 = (m_1/m_2)^a (l_1/l_2)^b (C_{F1}/C_{F2})^c

        with the powers of m, l and C_F that make up the dimension, so that the
        π-group of x stays the same; ``lever`` is a further power of r_w/N_d.
        """
        if self.same:
            return Interval(1.0, 1.0, 1.0)
        powers = {s: e for s, e in dim.exponents_of(dimension, REPEATING).items() if e}
        if lever:
            powers |= {"r_w": Fraction(lever), "N_d": Fraction(-lever)}
        first, second = product(self.first, powers), product(self.second, powers)
        assert first is not None, "every vehicle states these"
        assert second is not None, "every vehicle states these"
        return first.over(second)

    def of(self, name: str) -> Interval:
        """Return the factor of a quantity, or of a column by its unit.

        Raises
        ------
        InputError
            If it is neither, or its unit is electrical; the hint lists what there is.
        """
        plain = without_unit(name)
        if plain in SHAFT:
            wheel, lever = SHAFT[plain]
            return self.factor(wheel, lever)
        if name in QUANTITIES:
            return self.factor(QUANTITIES[name])
        if plain != name:
            dimension = dimension_of(name)
            if dimension is not None:
                return self.factor(dimension)
            raise InputError(
                f"{name}: does not scale: its unit is not one of mass, length, time",
                "scale the power, the torque or the energy instead",
            )
        close = get_close_matches(name, [*QUANTITIES, *SHAFT], n=1)
        like = f"did you mean `{close[0]}`? " if close else ""
        raise InputError(
            f"{name}: no such quantity",
            f"{like}there are {', '.join([*QUANTITIES, *SHAFT])}; "
            "a column with its unit, such as battery_power_w, serves too",
        )

    def all(self) -> dict[str, Interval]:
        """Return every named quantity's factor."""
        return {name: self.of(name) for name in [*QUANTITIES, *SHAFT]}

    def columns(
        self, table: Mapping[str, Scalable]
    ) -> tuple[dict[str, Any], list[str]]:
        """Scale columns by their units; return them, and the names left out.

        Dimensionless columns (throttle, slope) stay as they are; electrical and
        thermal ones have no scale and are left out.
        """
        scaled: dict[str, Any] = {}
        left_out = []
        for name, column in table.items():
            if dimension_of(name) is None:
                left_out.append(name)
            else:
                scaled[name] = column * self._of_column(name).value
        return scaled, left_out

    def _of_column(self, name: str) -> Interval:
        if without_unit(name) == name:
            return Interval(1.0, 1.0, 1.0)
        return self.of(name)


def scaled_quantity(
    quantity: str, value: float, *, to: Vehicle, of: Vehicle
) -> dict[str, Any]:
    """Return a quantity of one vehicle at the size of another, as a document."""
    factor = Scales.between(to, of).of(quantity)
    document: dict[str, Any] = {
        "quantity": quantity,
        "factor": factor.value,
        "value": factor.value * value,
    }
    if factor.low < factor.high:
        ends = sorted((factor.low * value, factor.high * value))
        document |= {
            "factor_low": factor.low,
            "factor_high": factor.high,
            "low": ends[0],
            "high": ends[1],
        }
    return document | {"from": of.name, "to": to.name}


def scaled_vehicle(
    vehicle: Vehicle, name: str, *, mass: float, length: float, force: float
) -> Vehicle:
    """Return the similar vehicle of another mass, length and cornering stiffness.

    Every figure with a unit of mass, length and time is multiplied by its scale;
    ratios stay, and so do electrical and thermal figures, which have none.

    Parameters
    ----------
    vehicle : Vehicle
        The one to copy.
    name : str
        What the copy is called.
    mass, length, force : float
        New over old: mass, every length, cornering stiffness. [1]

    Raises
    ------
    InputError
        If a factor is not positive, or the result is not a believable vehicle.
    """
    require_positive(mass=mass, length=length, force=force)
    settings: dict[str, Any] = {"vehicle.name": name}
    for key, figure in vehicle.figures().items():
        dimension = dimension_of(key)
        if dimension is None or dimension == dim.NONE:
            continue
        powers = dim.exponents_of(dimension, REPEATING)
        factor = (
            mass ** float(powers["m"])
            * length ** float(powers["l"])
            * force ** float(powers["C_F"])
        )
        settings[key] = _scaled_figure(figure, factor)
    changed = vehicle.changed(settings=settings)
    return build(changed.raw, path=None, origin=vehicle.origin)


def _scaled_figure(figure: Figure, factor: float) -> dict[str, float | str]:
    raw: dict[str, float | str] = {"value": figure.value * factor}
    if figure.sd:
        raw["sd"] = figure.sd * factor
    if figure.low is not None and figure.high is not None:
        raw |= {"low": figure.low * factor, "high": figure.high * factor}
    return raw | ({"source": figure.source} if figure.source else {})


def without_unit(name: str) -> str:
    """Return an edge name less its unit; whole if it carries none."""
    for suffix in SUFFIXES:
        if name.endswith("_" + suffix):
            return name.removesuffix("_" + suffix)
    return name
