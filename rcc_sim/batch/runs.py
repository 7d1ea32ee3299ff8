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
from rcc_sim.batch.store import Manifest
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.kernel import (
    check_slip,
    check_throttle,
    efficiency_map,
    force_table,
    open_circuit_voltage,
)
from rcc_sim.definitions.vehicle import Vehicle, build
from rcc_sim.errors import InputError, LedgerError
from rcc_sim.physics import params as schema
from rcc_sim.physics import record
from rcc_sim.physics.batch import RESULT, batch_commanded, batch_imposed
from rcc_sim.physics.ledger import CLOSES, LEAST, left_open
from rcc_sim.simulate.own import NotCompiled, own_terms
from rcc_sim.simulate.run import (
    LaneChanges,
    Profile,
    profile_of,
    refuse_degrees,
    sampling,
    yaw_rate_of,
)
from rcc_sim.units import J_PER_WH

if TYPE_CHECKING:
    import pyarrow

Array = NDArray[np.float64]

PERIOD = "effects.reference_sampling.period_s"

PART_STEPS = 4_000_000
"""Time steps of a part: about three quarters of a second."""

LEAST_PARTS, MOST_PARTS = 16, 10_000
"""Parts of a sweep: enough for every core, and not a file for every run."""

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


@dataclass(frozen=True)
class Outcome:
    """What the runs of a part came to: sums and peaks, and the ledgers."""

    out: Any
    ends: Any


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
    def packing(self) -> Packing:
        """From values to records."""
        plan = self.plan
        some = np.unique(np.linspace(0, plan.size - 1, 64).astype(int))
        rows = [plan.values(int(i), int(i) + 1)[0] for i in some]
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
            "keys": list(self.plan.keys),
            "shape": [*self.plan.shape, len(self.plan.draws)],
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
        """Raise an InputError for what no run of the sweep could do."""
        if self.how.lanes is not None and "lanes.every" not in self.plan.keys:
            self.how.lanes.params(self.packing.vehicle)
        if not self.how.imposed:
            given = self.how.throttle is not None
            check_throttle(self.packing.vehicle, given=given)
            assert self._sampling is not None

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
        roads = (
            profile_of(how.slope, 0.0, "slope"),
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
        bad = np.array([error is not None for error in errors])
        for i in np.flatnonzero(bad):
            record.fill(P[i], self.packing.base)
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
        errors = self._faults(errors, outcome)
        bad = np.array([error is not None for error in errors])
        columns: dict[str, Any] = {"run": np.arange(start, stop)}
        columns |= {key: values[:, i] for i, key in enumerate(self.plan.keys)}
        for name, figures in self._figures(outcome).items():
            columns[name] = pyarrow.array(figures, mask=bad)
        columns["error"] = pyarrow.array(errors, pyarrow.string())
        return pyarrow.table(columns)

    def _figures(self, outcome: Outcome) -> dict[str, Array]:
        out, ends = outcome.out, outcome.ends
        inside = ends["battery_resistance"]
        energy = (out["E"] - inside) / J_PER_WH
        with np.errstate(divide="ignore", invalid="ignore"):
            per_km = np.where(out["s"] > 0, energy / (out["s"] / 1000), np.nan)
        found = {
            "energy_wh": energy,
            "distance_m": out["s"],
            "duration_s": out["t"],
            "wh_per_km": per_km,
        }
        found |= {f"energy_{s}_wh": ends[s] / J_PER_WH for s in ends.dtype.names}
        found |= {name: out[symbol] for name, symbol in LIMITS.items()}
        if self.packing.base["motor"]["K_t"] == 0:
            del found["max_motor_current_a"]
        if open_circuit_voltage(self.packing.vehicle) is None:
            del found["max_battery_current_a"]
        return found | {"ledger_left_open": _left_open(outcome)}

    def _faults(
        self, errors: list[str | None], outcome: Outcome
    ) -> list[str | None]:
        """Return what is wrong with each run, now that it was done."""
        errors = list(errors)
        out, open_ = outcome.out, _left_open(outcome)
        wrong = ~(np.abs(open_) <= CLOSES) | (out["P_over"] > 1)
        for i in np.flatnonzero(wrong):
            errors[i] = errors[i] or self._fault(out[i], outcome.ends[i])
        return errors

    def _fault(self, result: Any, end: Any) -> str:
        if result["P_over"] > 1:
            return (
                f"effects.battery_resistance: the drive asks for "
                f"{result['P_over']:.2g} times the most power that the battery can give"
            )
        ledger = {name: float(end[name]) for name in end.dtype.names}
        try:
            left_open("run", float(result["E"]), ledger, float(result["E_abs"]))
        except LedgerError as error:
            return str(error).removeprefix("run: ")
        return "the energy ledger does not close"


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
    time, speed = setup.cycle
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


def _left_open(outcome: Outcome) -> Array:
    """Return what each ledger leaves open, as `left_open` has it."""
    lines = np.array([outcome.ends[name] for name in outcome.ends.dtype.names])
    through = np.maximum(outcome.out["E_abs"], np.abs(lines).sum(axis=0))
    left = outcome.out["E"] - lines.sum(axis=0)
    return np.asarray(left / np.maximum(through, LEAST))
