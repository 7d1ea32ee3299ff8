"""The runs of a sweep: records in, the kernel's loop over them, a table out."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcc_sim.batch.engine import version
from rcc_sim.batch.pack import CYCLE_KEYS, RATE, Packing, sound_vehicle
from rcc_sim.batch.plan import Plan
from rcc_sim.batch.results import Outcome, faults, figures
from rcc_sim.batch.store import Manifest
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.kernel import (
    check_slip,
    check_throttle,
    efficiency_map,
    force_table,
    open_circuit_voltage,
    road_of,
)
from rcc_sim.definitions.vehicle import Vehicle, build
from rcc_sim.errors import InputError
from rcc_sim.physics import params as schema
from rcc_sim.physics import record
from rcc_sim.physics.batch import RESULT, batch_commanded, batch_imposed
from rcc_sim.simulate.given import (
    Profile,
    profile_of,
    refuse_degrees,
    sampling,
    yaw_rate_of,
)
from rcc_sim.simulate.notes import coarse
from rcc_sim.simulate.own import NotCompiled, own_terms
from rcc_sim.simulate.run import LaneChanges
from rcc_sim.trace import integral_of

if TYPE_CHECKING:
    import pyarrow

Array = NDArray[np.float64]

PERIOD = "effects.reference_sampling.period_s"

PART_STEPS = 4_000_000
"""Time steps of a part: about three quarters of a second."""

FEW = 64
"""Runs that are looked at before anything starts."""

LEAST_PARTS, MOST_PARTS = 16, 10_000
"""Parts of a sweep: enough for every core, and not a file for every run."""


@dataclass(frozen=True)
class Manoeuvre:
    """How the drive is done, beside vehicle and cycle; as for `simulate`."""

    imposed: bool = False
    lanes: LaneChanges | None = None
    steer: Profile | None = None
    throttle: Profile | None = None
    yaw_rate: ArrayLike | None = None
    slope: Profile | None = None
    aux_power: Profile | None = None
    output_rate: float | None = None


@dataclass(frozen=True)
class Setup:
    """What every part of a sweep shares, as a process elsewhere can hold it."""

    imposed: bool
    raw: dict[str, Any]
    path: Path | None
    cycle: tuple[Array, Array]
    tables: tuple[Any, ...]
    maps: tuple[Any, Any]


@dataclass(frozen=True)
class Part:
    """The records of some runs, and what else differs between them."""

    P: Any
    scales: Array
    counts: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Sweep:
    """A vehicle over a cycle, at every point of a plan.

    Parameters
    ----------
    vehicle, cycle, how
        What drives, what, and how.
    plan : Plan
        What differs from run to run.

    Raises
    ------
    InputError
        From `check`, if it cannot be run at all.
    """

    vehicle: Vehicle
    cycle: Cycle
    plan: Plan
    how: Manoeuvre = Manoeuvre()

    @cached_property
    def _some(self) -> list[int]:
        """A few runs, from the first to the last, to judge the rest by."""
        few = np.linspace(0, self.plan.size - 1, FEW)
        return [int(i) for i in np.unique(few.astype(int))]

    @cached_property
    def packing(self) -> Packing:
        """From values to records."""
        plan = self.plan
        rows = [plan.values(i, i + 1)[0] for i in self._some]
        commanded = not self.how.imposed
        vehicle = sound_vehicle(self.vehicle, plan.keys, rows, commanded=commanded)
        return Packing(
            vehicle, commanded, plan.keys, plan.low, plan.high, self.how.lanes
        )

    @property
    def work(self) -> Any:
        """The function that does a part."""
        return drive_part

    @cached_property
    def manifest(self) -> Manifest:
        """What the rows follow from, in words and as a digest."""
        about = {
            "command": "sweep",
            "version": list(version()),
            "vehicle": self.vehicle.name,
            "cycle": self.cycle.name,
            "imposed": self.how.imposed,
            "lanes": None if self.how.lanes is None else asdict(self.how.lanes),
            "output_rate": self.how.output_rate,
            "grid": ", ".join(axis.words for axis in self.plan.axes),
            "drawn": ", ".join(self.plan.drawn),
            "draws": len(self.plan.draws),
        }
        own = [effect.digest for effect in own_terms(self.vehicle).effects]
        words = json.dumps([about, self.vehicle.raw, own], sort_keys=True, default=str)
        digest = hashlib.blake2b(words.encode(), digest_size=16)
        axes = (np.array(axis.values) for axis in self.plan.axes)
        setup = self.setup
        for numbers in _arrays((*axes, self.plan.draws, setup.cycle, setup.tables)):
            digest.update(numbers.tobytes())
        for numbers in _arrays(setup.maps):
            digest.update(numbers.tobytes())
        return Manifest(digest.hexdigest(), self.plan.size, self.part, about)

    def check(self) -> None:
        """Raise an InputError for what no run of the sweep could do.

        Of the runs that are looked at, one has to be sound.
        """
        if self.how.lanes is not None and "lanes.every" not in self.plan.keys:
            self.how.lanes.params(self.packing.vehicle)
        if not self.how.imposed:
            given = self.how.throttle is not None
            check_throttle(self.packing.vehicle, given=given)
            assert self._sampling is not None
        faults = [self.prepared(i, i + 1)[1][0] for i in self._some]
        if all(fault is not None for fault in faults):
            raise InputError(faults[0] or "")

    @cached_property
    def _sampling(self) -> tuple[int, int]:
        base = self.packing.base["control"]["T_loop"]
        return sampling(self.packing.vehicle, self.cycle, base, self.how.output_rate)

    @cached_property
    def part(self) -> int:
        """Runs of a part; it follows from the plan alone."""
        steps = len(self.cycle.time_s)
        if not self.how.imposed:
            steps = round(self.cycle.duration / self.packing.base["control"]["T_loop"])
        size = min(PART_STEPS // max(steps, 1), math.ceil(self.plan.size / LEAST_PARTS))
        return max(size, math.ceil(self.plan.size / MOST_PARTS), 1)

    @cached_property
    def setup(self) -> Setup:
        """What is sent once to each process."""
        how, car = self.how, self.packing.vehicle
        start = float(self.cycle.time_s[0])
        slope = road_of(car) if how.slope is None else how.slope
        roads = (
            profile_of(slope, 0.0, "slope"),
            profile_of(how.aux_power, start, "aux power"),
        )
        time = self.cycle.time_s
        tables: tuple[Any, ...]
        if how.imposed:
            tables = (yaw_rate_of(self.cycle, how.yaw_rate), *roads)
        else:
            time = time - start
            steering = profile_of(how.steer, start, "steer")
            refuse_degrees(steering[1])
            throttle = profile_of(how.throttle, start, "throttle")
            tables = (steering, throttle, *roads)
        maps = (efficiency_map(car), force_table(car))
        speed = np.array(self.cycle.speed_mps)
        return Setup(
            how.imposed, car.raw, car.path, (np.array(time), speed), tables, maps
        )

    def prepared(self, start: int, stop: int) -> tuple[Part, list[str | None]]:
        """Return the records of the runs from start to before stop, and their faults.

        A run with a fault has sound figures in its place.
        """
        values = self.plan.values(start, stop)
        P, errors = self.packing.records(values)
        if self.how.steer is not None:
            P["lanes"]["steer"] = schema.LOGGED
        scales = np.ones((len(values), 2))
        for i, key in enumerate(CYCLE_KEYS):
            if key in self.plan.keys:
                scales[:, i] = values[:, self.plan.keys.index(key)]
        counts = np.zeros((len(values), 2), dtype=np.int64)
        if not self.how.imposed:
            self._check_slip(P, scales, errors)
            self._count(P, scales, counts, errors)
        for i in [i for i, error in enumerate(errors) if error is not None]:
            record.fill(P[i:], self.packing.base)
            scales[i] = 1.0
            counts[i] = (1, 2)
        return Part(P, scales, counts), errors

    def _check_slip(self, P: Any, scales: Array, errors: list[str | None]) -> None:
        stiffness = P["longitudinal_slip"]["stiffness_n"]
        for i in np.flatnonzero((stiffness > 0) & np.isfinite(stiffness)):
            try:
                top = self.cycle.max_speed * scales[i, 1]
                check_slip(self.packing.vehicle, P[i], top)
            except InputError as error:
                errors[i] = errors[i] or str(error)

    def _count(
        self, P: Any, scales: Array, counts: Any, errors: list[str | None]
    ) -> None:
        """Write ticks per row and rows of each run."""
        counts[:] = self._sampling
        if not {RATE, PERIOD, CYCLE_KEYS[0]} & set(self.plan.keys):
            return
        for i, p in enumerate(P):
            car: Any = SimpleNamespace(
                controller=self.packing.vehicle.controller,
                effects={"reference_sampling": {"period_s": _held(p)}},
            )
            drive: Any = SimpleNamespace(duration=self.cycle.duration * scales[i, 0])
            try:
                T = float(p["control"]["T_loop"])
                counts[i] = sampling(car, drive, T, self.how.output_rate)
            except InputError as error:
                errors[i] = errors[i] or str(error)

    def table(
        self, start: int, errors: list[str | None], outcome: Outcome
    ) -> pyarrow.Table:
        """Return the rows of a part: inputs, ledger, distance, peaks, error."""
        import pyarrow

        stop = start + len(errors)
        values = self.plan.values(start, stop)
        errors = faults(errors, outcome)
        bad = np.array([error is not None for error in errors])
        columns: dict[str, Any] = {"run": np.arange(start, stop)}
        columns |= {key: values[:, i] for i, key in enumerate(self.plan.keys)}
        found = figures(outcome)
        if self.packing.base["motor"]["K_t"] == 0:
            del found["max_motor_current_a"]
        if open_circuit_voltage(self.packing.vehicle) is None:
            del found["max_battery_current_a"]
        for name, numbers in found.items():
            columns[name] = pyarrow.array(numbers, mask=bad)
        columns["error"] = pyarrow.array(errors, pyarrow.string())
        return pyarrow.table(columns)

    def notes(self) -> tuple[str, ...]:
        """Return what the runs would say of themselves, as far as it is known before.

        Imposed rows may lie too far apart to show lane changes.
        """
        if not self.how.imposed:
            return ()
        lengths = [
            (part.P["lanes"]["length"][0], part.scales[0].prod())
            for part, _ in (self.prepared(i, i + 1) for i in self._some)
            if part.P["lanes"]["steer"][0] == schema.FOLLOW
        ]
        if not lengths:
            return ()
        driven = integral_of(self.cycle.time_s, self.cycle.speed_mps)
        length, scale = min(lengths, key=lambda pair: pair[0] / pair[1])
        return coarse({"distance_m": driven * scale}, float(length))


def drive_part(setup: Setup, part: Part) -> Outcome:
    """Do the runs of a part: one call of the compiled kernel.

    Raises
    ------
    InputError
        If an effect of the user's own cannot be compiled.
    """
    own = own_terms(build(setup.raw, path=setup.path))
    n = len(part.P)
    sinks = record.floats(*own.sinks)
    out, ends = record.array(RESULT, n), record.array(sinks, n)
    work, blank = (tuple(record.array(s) for s in own.work) for _ in range(2))
    time = setup.cycle[0]
    rows = len(time) if setup.imposed else int(part.counts[:, 1].max())
    room = (record.array(schema.ROW, rows), record.array(sinks, rows))
    moving = (np.zeros(len(time)), np.zeros(len(time)))
    shared = (part.P, work, blank, setup.cycle, part.scales)
    try:
        if setup.imposed:
            drive: Any = (*moving, *setup.tables)
            own.call(batch_imposed, True, *shared, drive, setup.maps, *room, out, ends)
        else:
            drive = (moving, *setup.tables)
            lines = _delay_lines(part.P)
            own.call(
                batch_commanded,
                True,
                *shared,
                drive,
                setup.maps,
                lines,
                *room,
                part.counts,
                out,
                ends,
            )
    except NotCompiled as error:
        raise InputError(f"{error}, and many runs need that") from None
    return Outcome(out, ends)


def _delay_lines(P: Any) -> tuple[Array, Array]:
    T = P["control"]["T_loop"]
    delays = (P[n]["delay_s"] for n in ("actuation_delay", "steering_delay"))
    size = math.ceil(max(float((delay / T).max()) for delay in delays)) + 3
    return np.zeros(size), np.zeros(size)


def _arrays(tables: Any) -> Iterator[Array]:
    """Give every array in nested tuples."""
    for part in tables:
        if isinstance(part, tuple):
            yield from _arrays(part)
        else:
            yield np.ascontiguousarray(part)


def _held(p: Any) -> Any:
    return SimpleNamespace(value=float(p["reference_sampling"]["period_s"]))
