"""A full-size drive cycle at a car's size, inside its limits and its track."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.cycle import MAX_ROWS, Cycle
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError, require_positive
from rcc_sim.similitude.limits import Limit, drive_limits
from rcc_sim.similitude.scale import Scales
from rcc_sim.trace import integral_of

Array = NDArray[np.float64]
TINY = 1e-9
"""Difference of speed below which nothing was clipped. [m/s]"""


class Clip(NamedTuple):
    """What a clipping took away.

    Attributes
    ----------
    what : str
        "speed" or "acceleration".
    limit : float
        What it was clipped to. [m/s] or [m/s²]
    seconds : float
        How long the cycle is slower for it. [s]
    worst : float
        Greatest loss of speed. [m/s]
    distance : float
        Distance that is no longer driven. [m]
    """

    what: str
    limit: float
    seconds: float
    worst: float
    distance: float

    def line(self) -> str:
        """Return it in words."""
        unit = "m/s" if self.what == "speed" else "m/s²"
        if self.seconds == 0:
            return f"{self.what}: nothing to clip at {self.limit:g} {unit}"
        return (
            f"{self.what}: clipped at {self.limit:g} {unit} for {self.seconds:.3g} s, "
            f"at worst {self.worst:.3g} m/s slower, {self.distance:.3g} m shorter"
        )


class Track(NamedTuple):
    """A cycle against a straight track.

    Attributes
    ----------
    length, asked : float
        Of the track, and of the whole scaled cycle. [m]
    cut : float or None
        Time of the last stop on the track, where the cycle now ends. [s]
    driven : float
        What is left of the distance. [m]
    """

    length: float
    asked: float
    cut: float | None
    driven: float

    def line(self) -> str:
        """Return it in words."""
        need = (
            f"the cycle takes {self.asked:.4g} m, {self.asked / self.length:.3g} tracks"
        )
        if self.asked <= self.length:
            return f"{need}: it fits"
        if self.cut is None:
            return (
                f"{need}, and it does not stop before the first one's end: nothing was "
                "cut; cut it with NAME[start:stop], or turn on the move"
            )
        return (
            f"{need}; cut at its last stop on the track, {self.cut:.4g} s, after "
            f"{self.driven:.4g} m"
        )


@dataclass(frozen=True)
class ScaledCycle:
    """A cycle at a car's size.

    Parameters
    ----------
    cycle : Cycle
        The result.
    scales : Scales
        To the car from the vehicle that the cycle is of.
    clips : tuple of Clip
        What ``max_speed`` and ``max_accel`` took away.
    limits : tuple of Limit
        What the car can and cannot drive of it.
    track : Track or None
        If a track was given.
    """

    cycle: Cycle
    scales: Scales
    clips: tuple[Clip, ...]
    limits: tuple[Limit, ...]
    track: Track | None

    def rows(self) -> list[dict[str, float]]:
        """Return ``time_s, speed_mps``, one row a point."""
        pairs = zip(
            self.cycle.time_s.tolist(), self.cycle.speed_mps.tolist(), strict=True
        )
        return [{"time_s": t, "speed_mps": v} for t, v in pairs]

    def document(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        named = ("length", "speed", "time", "acceleration")
        return {
            "cycle": self.cycle.name,
            "from": self.scales.second.name,
            "to": self.scales.first.name,
            "scales": {name: self.scales.of(name).value for name in named},
            "duration_s": self.cycle.duration,
            "distance_m": self.cycle.distance,
            "max_speed_mps": self.cycle.max_speed,
            "clipped": [clip._asdict() for clip in self.clips],
            "limits": [limit.document() for limit in self.limits],
            "track": self.track._asdict() if self.track else None,
            "rows": self.rows(),
        }

    def lines(self) -> list[str]:
        """Return what a person should read beside the data."""
        speed, time = self.scales.of("speed").value, self.scales.of("time").value
        lines = [
            f"{self.cycle.name}: speed × {speed:.4g}, time × {time:.4g} "
            f"({self.scales.second.name} to {self.scales.first.name}); "
            f"{self.cycle.duration:.4g} s, {self.cycle.distance:.4g} m, "
            f"{self.cycle.max_speed:.4g} m/s at most"
        ]
        lines += [clip.line() for clip in self.clips]
        lines += [self.track.line()] if self.track else []
        lines += [
            f"cannot drive: {limit.line()}" for limit in self.limits if limit.exceeded
        ]
        fine = [x.what for x in self.limits if not x.exceeded and x.limit is not None]
        lines += [f"within: {', '.join(fine)}"] if fine else []
        return lines + [f"{x.what}: {x.note}" for x in self.limits if x.limit is None]


def scale_cycle(
    cycle: Cycle,
    *,
    to: Vehicle,
    of: Vehicle,
    rate: float | None = None,
    max_speed: float | None = None,
    max_accel: float | None = None,
    track_length: float | None = None,
) -> ScaledCycle:
    """Return a cycle of one vehicle at the size of another.

    Scaled first, then resampled, clipped in speed, clipped in acceleration, cut to the
    track; the options are at the car's size.

    Parameters
    ----------
    cycle : Cycle
        As the vehicle ``of`` drives it.
    to, of : Vehicle
        The car, and the vehicle that the cycle is of.
    rate : float, optional
        Rows a second of the result, straight lines between the cycle's rows; its last
        row is held to the end of the last period. [Hz]
    max_speed, max_accel : float, optional
        Most speed [m/s], and most acceleration and deceleration [m/s²]. The result is
        the fastest that keeps them and is nowhere faster than the cycle.
    track_length : float, optional
        Straight track: a longer cycle ends at its last stop on it, if it has one. [m]

    Raises
    ------
    InputError
        If an option is not positive, or the result is beyond reason.
    """
    options = {
        "--rate": rate,
        "--max-speed": max_speed,
        "--max-accel": max_accel,
        "--track-length": track_length,
    }
    require_positive(**{name: x for name, x in options.items() if x is not None})
    scales = Scales.between(to, of)
    time = cycle.time_s * scales.of("time").value
    speed = cycle.speed_mps * scales.of("speed").value
    if rate is not None:
        time, speed = _resampled(time, speed, rate)
    clips = []
    if max_speed is not None:
        clip, speed = _clipped("speed", max_speed, time, speed, _slower)
        clips.append(clip)
    if max_accel is not None:
        clip, speed = _clipped("acceleration", max_accel, time, speed, _gentler)
        clips.append(clip)
    scaled = Cycle(f"{cycle.name} at {to.name}", time, speed, cycle.source)
    track = None
    if track_length is not None:
        track, scaled = _on_track(scaled, track_length)
    limits = drive_limits(to, scaled)
    return ScaledCycle(scaled, scales, tuple(clips), tuple(limits), track)


def _resampled(time: Array, speed: Array, rate: float) -> tuple[Array, Array]:
    steps = np.ceil((time[-1] - time[0]) * rate - TINY)
    if steps + 1 > MAX_ROWS:
        raise InputError(f"--rate: should make at most {MAX_ROWS:,} rows: {steps:,.0f}")
    even = time[0] + np.arange(int(steps) + 1) / rate
    return even, np.interp(even, time, speed)


def _slower(time: Array, speed: Array, limit: float) -> Array:
    return np.minimum(speed, limit)


def _gentler(time: Array, speed: Array, limit: float) -> Array:
    """Return the fastest speed below ``speed`` that changes by no more than a limit."""
    gain = (limit * np.diff(time)).tolist()
    v = speed.tolist()
    for i, step in enumerate(gain):
        v[i + 1] = min(v[i + 1], v[i] + step)
    for i in range(len(gain) - 1, -1, -1):
        v[i] = min(v[i], v[i + 1] + gain[i])
    return np.array(v)


def _clipped(
    what: str,
    limit: float,
    time: Array,
    speed: Array,
    clip: Callable[[Array, Array, float], Array],
) -> tuple[Clip, Array]:
    clipped = clip(time, speed, limit)
    lost = speed - clipped
    touched = np.maximum(lost[1:], lost[:-1]) > TINY
    report = Clip(
        what=what,
        limit=limit,
        seconds=float(np.diff(time)[touched].sum()),
        worst=float(lost.max()),
        distance=float(np.trapezoid(lost, time)),
    )
    return report, clipped


def _on_track(cycle: Cycle, length: float) -> tuple[Track, Cycle]:
    if cycle.distance <= length:
        return Track(length, cycle.distance, None, cycle.distance), cycle
    time, speed = cycle.time_s, cycle.speed_mps
    driven = integral_of(time, speed)
    stops = np.flatnonzero((speed == 0) & (driven > 0) & (driven <= length))
    if not stops.size:
        return Track(length, cycle.distance, None, cycle.distance), cycle
    end = int(stops[-1])
    cut = Cycle(cycle.name, time[: end + 1], speed[: end + 1], cycle.source)
    return Track(length, cycle.distance, float(time[end]), float(driven[end])), cut
