"""What no effect of the library explains: how much, where it sits, what it follows."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.engine import MEMORY, Engine, Fit
from rcc_sim.diagnose.profile import Probe, Profile, overlap, probe_size

Array = NDArray[np.float64]

UNKNOWN_ENOUGH = 30.0
"""Nats beyond which a remainder is a real one."""

CARRIERS = {
    "drag": ("effects.drivetrain_friction.torque_nm", "effects.road_load.a_n"),
    "power": ("effects.auxiliary_load.power_w",),
    "steer": ("effects.steering_offset.angle_rad",),
}
"""How something unknown may act: as a drag, a power, an angle of the wheels; and the
figure by which the model is made to do so (the second, where a file states it)."""

ITSELF = {"auxiliary_load": "power"}
"""Effect -> the way of acting that is its own."""

FOLLOWS = {
    "time_s": (25, 40),
    "speed_mps": (16,),
    "steer_cmd_rad": (16,),
}
"""What it may follow, and by how many knots."""

WINDOWS = 50
"""Stretches of a log below a quarter of which gaps between windows are closed."""


@dataclass(frozen=True)
class Remainder:
    """The likeliest form of what is left.

    Parameters
    ----------
    evidence : float
        Nats for it against nothing.
    acts_as, follows : str
        How it acts, and the column that it follows.
    windows : list of dict
        start_s, end_s, channel and share of where it acted.
    profile : Profile or None
        Its strength.
    log : int
        Log in which it is clearest.
    shares : ndarray
        Share of each track in it.
    rivals : tuple of Remainder
        The likeliest by each way of acting, this one among them.
    """

    evidence: float
    acts_as: str
    follows: str
    windows: list[dict[str, Any]]
    profile: Profile | None = None
    log: int = 0
    shares: Array = field(default_factory=lambda: np.zeros(0))
    rivals: tuple[Remainder, ...] = ()

    def against(self, effect: str, shares: Array) -> float:
        """Nats of what is left in the tracks in which a cause shows itself.

        An unknown power is an auxiliary load that varies, and does not speak against
        one.
        """
        rivals = [r for r in self.rivals if ITSELF.get(effect) != r.acts_as]
        return max((r.evidence * overlap(r.shares, shares) for r in rivals), default=0)

    @property
    def is_real(self) -> bool:
        """Whether it is beyond what chance leaves."""
        return self.evidence > UNKNOWN_ENOUGH


def remainder(engine: Engine, fit: Fit) -> Remainder:
    """Return the likeliest form of what a fit leaves unexplained."""
    steered = all(p.drive.steered for p in engine.problems)
    stated = engine.problems[0].vehicle.figures()
    each = []
    for name, keys in CARRIERS.items():
        if name == "steer" and not steered:
            continue
        key = next((k for k in keys[1:] if k in stated), keys[0])
        probe = Probe(engine, fit, key, probe_size(engine, key))
        each.append(likeliest_of(probe, name))
    best = max(each, key=lambda r: r.evidence)
    return replace(best, rivals=tuple(each))


def likeliest_of(probe: Probe, name: str) -> Remainder:
    """Return the likeliest form of one way of acting."""
    best = Remainder(0.0, name, "", [], shares=probe.shares)
    for i, problem in enumerate(probe.engine.problems):
        for along, counts in FOLLOWS.items():
            if along == "speed_mps":
                x = problem.speed
            elif along in problem.log:
                x = np.nan_to_num(problem.log[along])
            else:
                continue
            if along == "time_s":  # no finer than the noise remembers
                most = int((x[-1] - x[0]) / MEMORY) + 1
                counts = tuple(n for n in counts if n <= max(most, counts[0]))
            tried = [probe.profile(i, along, x, count) for count in counts]
            profile = max(tried, key=lambda p: p.evidence)
            if profile.evidence > best.evidence:
                found = windows_of(probe, i, profile, x)
                best = Remainder(
                    profile.evidence, name, along, found, profile, i, probe.shares
                )
    return best


def windows_of(
    probe: Probe, log: int, profile: Profile, x: Array
) -> list[dict[str, Any]]:
    """Stretches in which a profile is clearly there, with their shares of it."""
    time = probe.engine.problems[log].log["time_s"]
    clear = profile.clear_at(x)
    tracks = [i for i in probe.tracks if probe.engine.tracks[i][0] == log]
    power = np.zeros(len(time))
    strongest, channel = 0.0, ""
    for i in tracks:
        w = probe.fit.noise[i]
        part = np.zeros(len(time))
        part[w.valid] = w(probe.signal[i] * profile.at(x)) ** 2
        power += part
        if float(part.sum()) > strongest:
            strongest, channel = float(part.sum()), probe.engine.tracks[i][1]
    gap = 2.0 * (time[-1] - time[0]) / WINDOWS
    edges = np.flatnonzero(np.diff(np.concatenate([[0], clear.astype(int), [0]])))
    spans: list[list[int]] = []
    for a, b in edges.reshape(-1, 2):
        if spans and time[a] - time[spans[-1][1] - 1] < 0.25 * gap:
            spans[-1][1] = int(b)
        else:
            spans.append([int(a), int(b)])
    total = float(power.sum()) or 1.0
    out = [
        {
            "start_s": float(time[a]),
            "end_s": float(time[b - 1]),
            "channel": channel,
            "share": float(power[a:b].sum()) / total,
        }
        for a, b in spans
    ]
    return [
        w
        for w, (a, b) in zip(out, spans, strict=True)
        if power[a:b].sum() > 0.01 * total
    ]
