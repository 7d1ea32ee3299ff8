"""From a table of values to the kernel's records, a record a run, all at once.

Which fields of the record a key stands in is found by trying: the fields that follow
the key's value from its least to its greatest are written straight. The few that are
worked out of several keys have their formula here. Where neither holds, and wherever a
value may be refused, the vehicle is built anew for each run, as `simulate` would.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.kernel import DRIVER_TIMES, kernel_params
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics import params as schema
from rcc_sim.physics import record
from rcc_sim.physics.powertrain import torque_constant
from rcc_sim.simulate.own import own_terms
from rcc_sim.simulate.run import LaneChanges

Array = NDArray[np.float64]
Column = Callable[[str], Any]
Place = tuple[str, str]
Values = Mapping[str, Mapping[str, float]]

CYCLE_KEYS = ("cycle.time_scale", "cycle.speed_scale")
LANE_KEYS = ("lanes.every", "lanes.width", "lanes.length")

MASS = "body.mass_kg"
AXLES = ("body.cg_to_front_axle_m", "body.cg_to_rear_axle_m")
STIFFNESS = "tyres.front_cornering_stiffness_n_per_rad"
FLUX = "motor.flux_linkage_wb"
RATE = "controller.loop_rate_hz"
TORQUES = ("motor.max_torque_nm", "controller.max_torque_nm")
SPEEDS = ("motor.max_speed_radps", "controller.max_electrical_speed_radps")

TOGETHER = (
    MASS,
    "body.yaw_inertia_kgm2",
    *AXLES,
    "tyres.radius_m",
    "effects.payload.mass_kg",
    "effects.cg_shift.shift_m",
)
"""Keys that are each believable and together may not be; each rule is monotone."""


@dataclass(frozen=True)
class Formula:
    """A field that is worked out of several keys, for whole columns."""

    keys: tuple[str, ...]
    of: Callable[[Column, Vehicle], Any]


def _largest_torque(get: Column, vehicle: Vehicle) -> Any:
    shaft, asked = (get(key) for key in TORQUES)
    return np.minimum(inf if shaft is None else shaft, inf if asked is None else asked)


def _top_speed(get: Column, vehicle: Vehicle) -> Any:
    shaft, electrical = (get(key) for key in SPEEDS)
    limit = inf if shaft is None else shaft
    if electrical is None or vehicle.motor.poles is None:
        return limit
    return np.minimum(limit, electrical / (vehicle.motor.poles / 2))


def _driver_time(get: Column, vehicle: Vehicle) -> Any:
    stated = get("controller.driver_time_constant_s")
    if stated is not None:
        return stated
    return DRIVER_TIMES * np.sqrt(get(MASS) * _wheelbase(get) / get(STIFFNESS))


def _wheelbase(get: Column) -> Any:
    return get(AXLES[0]) + get(AXLES[1])


FORMULAS: dict[Place, Formula] = {
    ("motor", "K_t"): Formula(
        (FLUX,), lambda get, car: torque_constant(car.motor.poles, get(FLUX))
    ),
    ("motor", "psi"): Formula(
        (FLUX,), lambda get, car: (car.motor.poles or 0) / 2 * get(FLUX)
    ),
    ("motor", "tau_max"): Formula(TORQUES, _largest_torque),
    ("motor", "omega_max"): Formula(SPEEDS, _top_speed),
    ("control", "T_loop"): Formula((RATE,), lambda get, car: 1.0 / get(RATE)),
    ("control", "T_driver"): Formula(
        ("controller.driver_time_constant_s", MASS, *AXLES, STIFFNESS), _driver_time
    ),
}
"""Field of the record -> what it is made of; a test holds it to `kernel_params`."""


@dataclass(frozen=True, eq=False)
class Packing:
    """How the values of a sweep become records.

    Parameters
    ----------
    vehicle : Vehicle
        With every key of the vehicle's own at a value that it takes in the sweep.
    commanded : bool
        Whether its controller drives.
    keys : tuple of str
        Column -> key.
    low, high : ndarray, shape (k,)
        Least and greatest value of each key in the whole sweep.
    lanes : LaneChanges or None
        Lane changes, as far as the keys do not say otherwise.
    """

    vehicle: Vehicle
    commanded: bool
    keys: tuple[str, ...]
    low: Array
    high: Array
    lanes: LaneChanges | None = None

    @cached_property
    def base(self) -> dict[str, dict[str, float]]:
        """The kernel's parameters of the vehicle as it stands."""
        return kernel_params(self.vehicle, commanded=self.commanded)

    @cached_property
    def own_keys(self) -> tuple[str, ...]:
        """The keys that belong to the vehicle's file."""
        return tuple(k for k in self.keys if k not in (*CYCLE_KEYS, *LANE_KEYS))

    @cached_property
    def _plan(self) -> tuple[dict[Place, str], tuple[Place, ...], bool]:
        """Fields written straight, fields by formula, and whether that is all."""
        worked_out = tuple(
            place
            for place, formula in FORMULAS.items()
            if set(formula.keys) & set(self.own_keys) and self._acts(place)
        )
        straight: dict[Place, str] = {}
        for key in self.own_keys:
            low, high = self._range(key)
            try:
                least, most = self._at({key: low}), self._at({key: high})
            except InputError:
                return {}, (), False
            for place in changed_places(least, most):
                if place in worked_out:
                    continue
                if place in straight or (_get(least, place), _get(most, place)) != (
                    low,
                    high,
                ):
                    return {}, (), False
                straight[place] = key
        return straight, worked_out, self._sound_together()

    def _acts(self, place: Place) -> bool:
        """Whether any of a formula's keys moves its field at all."""
        keys = [k for k in FORMULAS[place].keys if k in self.own_keys]
        ends = (
            dict(zip(keys, values, strict=True))
            for values in itertools.product(*(self._range(key) for key in keys))
        )
        seen = set()
        for values in ends:
            try:
                seen.add(_get(self._at(values), place))
            except InputError:
                return True
        return len(seen) > 1

    def _range(self, key: str) -> tuple[float, float]:
        column = self.keys.index(key)
        return float(self.low[column]), float(self.high[column])

    def _at(self, values: Mapping[str, float]) -> Values:
        changed = self.vehicle.changed(settings=dict(values))
        return kernel_params(changed, commanded=self.commanded)

    def _sound_together(self) -> bool:
        """Whether the corners of what goes together are sound; then all within is."""
        keys = [key for key in TOGETHER if key in self.own_keys]
        for values in itertools.product(*(self._range(key) for key in keys)):
            try:
                self._at(dict(zip(keys, values, strict=True)))
            except InputError:
                return False
        return True

    @property
    def straight(self) -> bool:
        """Whether the records are written straight, without a vehicle for each."""
        return self._plan[2]

    def records(self, values: Array) -> tuple[Any, list[str | None]]:
        """Return the records of some runs, and what is wrong with each, or None.

        Parameters
        ----------
        values : ndarray, shape (n, k)
            A row a run, a column a key.
        """
        P = record.array(own_terms(self.vehicle).params, len(values))
        errors: list[str | None] = [None] * len(values)
        if not len(values):
            return P, errors
        record.fill(P, self.base)
        P[1:] = P[0]
        column = {key: values[:, i] for i, key in enumerate(self.keys)}

        def get(key: str) -> Any:
            if key in column:
                return column[key]
            stated = self.figures.get(key)
            return None if stated is None else stated.value

        fields, worked_out, straight = self._plan
        if straight:
            for (table, name), key in fields.items():
                P[table][name] = column[key]
            for place in worked_out:
                P[place[0]][place[1]] = FORMULAS[place].of(get, self.vehicle)
        else:
            self._one_by_one(P, errors, values)
        self._write_lanes(P["lanes"], errors, get)
        self._check_scales(errors, column)
        return P, errors

    @cached_property
    def figures(self) -> Mapping[str, Any]:
        """Key -> figure, of what the vehicle states."""
        return self.vehicle.figures()

    def _one_by_one(self, P: Any, errors: list[str | None], values: Array) -> None:
        where = [self.keys.index(key) for key in self.own_keys]
        for i, row in enumerate(values):
            at = dict(zip(self.own_keys, row[where].tolist(), strict=True))
            try:
                record.fill(P[i:], self._at(at))
            except InputError as error:
                errors[i] = str(error)

    def _write_lanes(self, lanes: Any, errors: list[str | None], get: Column) -> None:
        """Write the path of each run, as ``LaneChanges.params`` would."""
        n = len(lanes)
        given = self.lanes or LaneChanges(inf)
        parts = (given.every, given.width, given.length)
        every, width, length = (
            _column(get(key), fixed, n)
            for key, fixed in zip(LANE_KEYS, parts, strict=True)
        )
        changes = ~np.isposinf(every)
        l = np.broadcast_to(_wheelbase(get), n)
        width = np.where(np.isnan(width), l, width)
        length = np.where(np.isnan(length), np.minimum(every, 20 * l), length)
        good = (every > 0) & (length > 0) & (length <= every) & np.isfinite(width)
        lanes["steer"] = np.where(changes, schema.FOLLOW, schema.STRAIGHT)
        for name, wanted, none in (
            ("every", every, inf),
            ("width", width, 0.0),
            ("length", length, 1.0),
        ):
            lanes[name] = np.where(changes, wanted, none)
        for i in np.flatnonzero(changes & ~good):
            try:
                LaneChanges(every[i], width[i], length[i]).params(self.vehicle)
            except InputError as error:
                errors[i] = errors[i] or str(error)

    def _check_scales(
        self, errors: list[str | None], column: Mapping[str, Array]
    ) -> None:
        for key in CYCLE_KEYS:
            for i in np.flatnonzero(~(column.get(key, np.ones(1)) > 0)):
                errors[i] = errors[i] or (
                    f"{key}: should be positive: {column[key][i]:g}"
                )


def changed_places(one: Values, other: Values) -> list[Place]:
    """Return the fields in which two sets of the kernel's parameters differ."""
    return [
        (table, name)
        for table, fields in one.items()
        for name, value in fields.items()
        if value != other[table][name]
    ]


def sound_vehicle(
    vehicle: Vehicle, keys: Sequence[str], rows: Sequence[Array], *, commanded: bool
) -> Vehicle:
    """Return the vehicle at the first of some rows of values that it accepts.

    Raises
    ------
    InputError
        What is wrong with the first row, if none is accepted.
    """
    first: InputError | None = None
    own = [(i, k) for i, k in enumerate(keys) if k not in (*CYCLE_KEYS, *LANE_KEYS)]
    for row in rows:
        try:
            at = {key: float(row[i]) for i, key in own}
            changed = vehicle.changed(settings=at) if at else vehicle
            kernel_params(changed, commanded=commanded)
        except InputError as error:
            first = first or error
        else:
            return changed
    assert first is not None
    raise first


def _get(values: Values, place: Place) -> float:
    return values[place[0]].get(place[1], 0.0)


def _column(values: Any, fixed: float | None, n: int) -> Array:
    """Return a column: its values, else what is fixed, else NaN."""
    if values is not None:
        return np.asarray(values, dtype=float)
    return np.full(n, np.nan if fixed is None else fixed)
