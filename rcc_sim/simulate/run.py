"""A vehicle and a cycle make a run: commanded, or imposed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.kernel import (
    check_slip,
    check_throttle,
    efficiency_map,
    force_table,
    kernel_params,
    road_of,
)
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.jit import compiler_is_loaded
from rcc_sim.physics import params as schema
from rcc_sim.physics import record
from rcc_sim.physics.ledger import left_open
from rcc_sim.physics.run import run_commanded, run_imposed
from rcc_sim.simulate.columns import trace_columns
from rcc_sim.simulate.given import (
    Profile,
    at_rate,
    profile_of,
    refuse_degrees,
    sampling,
    yaw_rate_of,
)
from rcc_sim.simulate.notes import run_notes
from rcc_sim.simulate.own import NotCompiled, OwnTerms, own_terms
from rcc_sim.simulate.sensors import sensed_columns
from rcc_sim.trace import Trace

Engine = Literal["auto", "compiled", "interpreted"]

FEW_ROWS = 20_000
"""Imposed runs up to this many rows are done before a compiler would be loaded."""


@dataclass(frozen=True)
class LaneChanges:
    """A lane change every so many metres, from lane to lane and back.

    Parameters
    ----------
    every : float
        Distance between the starts of two changes. [m]
    width : float or None
        Distance between the lanes; one wheelbase where not given (3.45 m, a road
        lane, for a pick-up; the same lane in scale for a scaled car). [m]
    length : float or None
        Distance that a change takes; 20 wheelbases, at most ``every``, where not
        given. [m]
    """

    every: float
    width: float | None = None
    length: float | None = None

    def params(self, vehicle: Vehicle) -> dict[str, float]:
        """Return what the kernel's path follower reads.

        Raises
        ------
        InputError
            If a length is not positive, or a change is longer than their distance.
        """
        l = vehicle.wheelbase
        width = l if self.width is None else self.width
        length = min(self.every, 20 * l) if self.length is None else self.length
        for name, value in (("every", self.every), ("length", length)):
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"lane change {name}: should be positive: {value:g} m")
        if not math.isfinite(width):
            raise InputError(f"lane width: should be finite: {width:g} m")
        if length > self.every:
            raise InputError(
                f"lane change: takes {length:g} m, and one starts every"
                f" {self.every:g} m"
            )
        return {
            "steer": schema.FOLLOW,
            "every": self.every,
            "width": width,
            "length": length,
        }


@dataclass(frozen=True)
class Run:
    """What a simulated drive gave.

    Parameters
    ----------
    trace : Trace
        Time series, with the ledger as cumulative columns.
    ledger : dict
        Sink -> energy that went there over the whole run. [J]
    battery_energy : float
        Energy that the battery's cells gave. [J]
    throughput : float
        Energy that went through the battery, either way. [J]
    residual : float
        What the ledger leaves open, as a fraction of the throughput.
    notes : tuple of str
        What went beyond the vehicle's means, in words.
    """

    trace: Trace
    ledger: dict[str, float]
    battery_energy: float
    throughput: float
    residual: float
    notes: tuple[str, ...] = field(default=())


def simulate(
    vehicle: Vehicle,
    cycle: Cycle,
    *,
    imposed: bool = False,
    lanes: LaneChanges | None = None,
    steer: Profile | None = None,
    throttle: Profile | None = None,
    yaw_rate: ArrayLike | None = None,
    slope: Profile | None = None,
    aux_power: Profile | None = None,
    output_rate: float | None = None,
    substeps: int = 1,
    engine: Engine = "auto",
) -> Run:
    """Drive a vehicle over a cycle.

    Parameters
    ----------
    vehicle, cycle
        What drives, and how fast it should.
    imposed : bool
        Take the cycle's speed as it is, at the cycle's own step, and work out what
        it costs; otherwise the vehicle's controller follows it at its own rate.
    lanes : LaneChanges or None
        Lane changes by distance driven, by a path follower.
    steer : (time, angle) or None
        Commanded steering angle over time, in place of the follower. [s], [rad]
    throttle : (time, throttle) or None
        Throttle over time, for a vehicle in throttle mode; the cycle then gives the
        speed at the start and the duration. [s], [1]
    yaw_rate : array_like of shape (n,) or None
        Yaw rate at the cycle's rows, for imposed runs. [rad/s]
    slope : (distance, slope) or None
        Slope of the road over distance from the start. [m], [1]
    aux_power : (time, power) or None
        Auxiliary power that was logged, on top of the file's. [s], [W]
    output_rate : float or None
        Rows per second; of an imposed run, no fewer than the cycle's. [Hz]
    substeps : int
        Time steps per tick of the control loop.
    engine : {"auto", "compiled", "interpreted"}
        Machine code or plain Python: the same result to the last bit.

    Raises
    ------
    InputError
        If the vehicle lacks a figure that the run needs.
    LedgerError
        If the energy ledger does not close to 1e-6 of the throughput.
    """
    if imposed and output_rate is not None:
        cycle, yaw_rate = at_rate(cycle, yaw_rate, output_rate)
    values = kernel_params(vehicle, commanded=not imposed)
    if lanes is not None:
        values["lanes"] = lanes.params(vehicle)
    if steer is not None:
        values["lanes"]["steer"] = schema.LOGGED
    start = float(cycle.time_s[0])
    slope = road_of(vehicle) if slope is None else slope
    roads = (profile_of(slope, 0.0, "slope"), profile_of(aux_power, start, "aux power"))
    if imposed:
        rows = len(cycle.time_s)
        tail: tuple[int, ...] = ()
        drive: tuple[Any, ...] = (
            cycle.time_s,
            cycle.speed_mps,
            yaw_rate_of(cycle, yaw_rate),
            *roads,
        )
    else:
        check_throttle(vehicle, given=throttle is not None)
        check_slip(vehicle, values, cycle.max_speed)
        T_loop = values["control"]["T_loop"]
        every, rows = sampling(vehicle, cycle, T_loop, output_rate)
        tail = (every, substeps)
        reference = (cycle.time_s - start, cycle.speed_mps)
        steering = profile_of(steer, start, "steer")
        refuse_degrees(steering[1])
        drive = (reference, steering, profile_of(throttle, start, "throttle"), *roads)
    fast = engine == "compiled" or (
        engine == "auto" and (not imposed or rows > FEW_ROWS or compiler_is_loaded())
    )
    maps = (efficiency_map(vehicle), force_table(vehicle))
    kernel: Callable[..., Any] = run_imposed if imposed else run_commanded
    lines = () if imposed else (delay_lines(values),)
    own = own_terms(vehicle)

    def driven(fast: bool) -> tuple[Any, Any, Any]:
        make = record.array if fast else record.plain
        P, work = make(own.params), tuple(make(s) for s in own.work)
        table, sinks = make(schema.ROW, rows), make(record.floats(*own.sinks), rows)
        record.fill(P, values)
        own.call(kernel, fast, P, work, drive, maps, *lines, table, sinks, *tail)
        own.check(table, sinks)
        return work, table, sinks

    changes = values["lanes"]["length"] if lanes is not None else math.inf
    try:
        return _run(vehicle, cycle, *driven(fast), own, changes)
    except NotCompiled as error:
        slow = _run(vehicle, cycle, *driven(False), own, changes)
        note = f"{error}: it ran in plain Python, which is slower"
        return replace(slow, notes=(*slow.notes, note))


def _run(
    vehicle: Vehicle,
    cycle: Cycle,
    work: Any,
    table: Any,
    sinks: Any,
    own: OwnTerms,
    lane_length: float,
) -> Run:
    chassis, flow = work[0][0], work[4][0]
    get = (lambda r, k: r[k]) if isinstance(work[0], np.ndarray) else getattr
    columns = trace_columns(
        vehicle,
        table,
        sinks,
        own.sinks,
        n=float(get(chassis, "n")),
        n_file=float(get(chassis, "n_file")),
        K_t=float(get(chassis, "K_t")),
    )
    if cycle.time_s[0] != columns["time_s"][0]:
        columns["time_s"] = columns["time_s"] + float(cycle.time_s[0])
    ledger = {
        sink: float(columns[f"energy_{sink}_j"][-1])
        for sink in own.sinks
        if f"energy_{sink}_j" in columns
    }
    given = float(columns["battery_energy_j"][-1])
    throughput = float(get(flow, "E_abs"))
    beyond = {k: float(get(flow, k)) for k in schema.FLOW}
    notes = run_notes(vehicle, cycle, columns, beyond, lane_length)
    name = f"{vehicle.name} on {cycle.name}"
    residual = left_open(name, given, ledger, throughput)
    trace = Trace(sensed_columns(vehicle, columns), name=name)
    return Run(trace, ledger, given, throughput, residual, notes)


def delay_lines(
    values: dict[str, dict[str, float]],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the ring buffers of the motor's and the steering's dead time."""
    delays = (values[n]["delay_s"] for n in ("actuation_delay", "steering_delay"))
    longest = max(delays) / values["control"]["T_loop"]
    size = math.ceil(longest) + 3
    return np.zeros(size), np.zeros(size)
