"""What no effect of the library explains: how much, where it sits, what it follows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.finding import runs
from rcc_sim.diagnose.causes.cause import TIED, Cause
from rcc_sim.diagnose.causes.profile import Profile, overlap
from rcc_sim.diagnose.fitting.engine import MEMORY, Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.profiles.altimeter import Wander, wander
from rcc_sim.diagnose.profiles.bursts import bursts
from rcc_sim.diagnose.profiles.forms import (
    AFTER,
    CARRIERS,
    CHANGES,
    CORNERING,
    DRAG_OVER_TIME,
    EFFICIENT,
    FEED,
    FOLLOWS,
    ITSELF,
    MODELLED,
    OTHERS,
    STEERING,
    carrier_of,
)
from rcc_sim.diagnose.profiles.probe import Probe
from rcc_sim.diagnose.profiles.warming import WARMS, warming
from rcc_sim.diagnose.residuals.losses import evened
from rcc_sim.side_by_side import each

Array = NDArray[np.float64]

UNKNOWN_ENOUGH, ROUGH_ENOUGH = 40.0, 50.0
"""Nats beyond which a remainder is a real one; the second for a drag that follows time,
which a rough road is, too, unless the energy is off as well. Of 284 drives of the blind
plant without a cause (200 of them `rccsim blind make --kinds null --cases 200 --seed
9001`) six leave 40 nats or more of such a drag, one more than 44, and none more than 31
of anything else."""

AFTER_ENOUGH, LATERAL_ENOUGH = 30.0, 15.0
"""The same for what follows the time since braking or a stop, and for a grip or an
angle that changes, of which a rough road knows nothing: of 264 such drives none had
one that gained more than 21, or more than 3. Of 114, and of 65 with a cause that shows
in cornering, none was more restless there than by 2."""

EXACT = 1e-3
"""Share of how a channel moves below which no model is exact: over ten hours that is
more nats than chance leaves in ten minutes."""

WINDOWS = 50
"""Stretches of a log below half of which gaps between windows are closed."""


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
    inexact : float
        Nats that a model may leave that is as exact as models are (``EXACT``).
    heights : Wander or None
        What an altimeter that wanders would make of it.
    opens_gap : bool
        The energy is off by more than its doubt, as no rough road has it.
    apart : frozenset of str
        Effects that stand beside an efficiency that varies.
    """

    evidence: float
    acts_as: str
    follows: str
    windows: list[dict[str, Any]]
    profile: Profile | None = None
    log: int = 0
    shares: Array = field(default_factory=lambda: np.zeros(0))
    rivals: tuple[Remainder, ...] = ()
    inexact: float = 0.0
    heights: Wander | None = None
    opens_gap: bool = False
    apart: frozenset[str] = frozenset()

    def against(self, effect: str, shares: Array) -> float:
        """Nats of what is left in the tracks in which a cause shows itself.

        An unknown power is an auxiliary load that varies, and does not speak against
        one; nor does that load's own coming and going, nor an efficiency beside which
        it stands. Nor does what chance may leave, beside something real.
        """
        own = {effect, ITSELF[effect]} if effect in ITSELF else set()
        own |= {EFFICIENT} if effect in self.apart else set()
        rivals = [
            r for r in self.rivals if r.acts_as not in own and r.is_real == self.is_real
        ]
        return max((r.evidence * overlap(r.shares, shares) for r in rivals), default=0)

    def change_of(self, effect: str) -> float:
        """Nats by which a cause that was taken as constant comes and goes instead.

        One that may vary does so as it may.
        """
        if effect in ITSELF:
            return 0.0
        return max((r.evidence for r in self.rivals if r.acts_as == effect), default=0)

    @property
    def is_real(self) -> bool:
        """Whether it is beyond what chance leaves."""
        return self.evidence > self.enough

    @property
    def enough(self) -> float:
        """Nats that chance, the model, or an altimeter may leave."""
        if self.heights and self.heights.is_known:
            return inf
        if self.acts_as in CORNERING:
            chance = LATERAL_ENOUGH
        elif (self.acts_as, self.follows) == DRAG_OVER_TIME and not self.opens_gap:
            chance = ROUGH_ENOUGH
        else:
            chance = AFTER_ENOUGH if self.follows in AFTER else UNKNOWN_ENOUGH
        return max(chance, self.inexact)


def clearest(rivals: Iterable[Remainder]) -> Remainder:
    """Return the likeliest of those that are real, else of all."""
    return max(rivals, key=lambda r: (r.is_real, r.evidence))


def remainder(
    engine: Engine, fit: Fit, constant: Mapping[str, Sequence[str]] | None = None
) -> Remainder:
    """Return the likeliest form of what a fit leaves unexplained.

    ``constant`` holds effects that the fit takes as constant, and their figures: that
    one of them changes with time, or with the steering, is a form as well. But for a
    delay: within a row it makes readings smoother or rougher, and that is what would
    come and go.
    """
    steered = all(p.drive.steered for p in engine.problems)
    forms: list[Callable[[], list[Remainder]]] = []
    for name in CARRIERS:
        if name in CORNERING and not steered:
            continue
        key = carrier_of(engine, fit, name)
        forms.append(partial(acting_as, engine, fit, name, key))
    forms += [
        partial(restless, engine, fit, log) for log in range(len(engine.problems))
    ]
    for name, figures in (constant or {}).items():
        for knob in fit.knobs:
            if knob.key in figures and knob.acts != "rows":
                forms.append(partial(changing, engine, fit, name, knob))
    power = inexactness(engine, fit)
    every = [
        replace(r, inexact=float(power @ r.shares)) if len(r.shares) else r
        for found in each(lambda form: form(), forms)
        for r in found
    ]
    every = [as_heights(engine, fit, r) for r in every]
    return replace(clearest(every), rivals=tuple(every))


def as_heights(engine: Engine, fit: Fit, left: Remainder) -> Remainder:
    """Return what is left, with the heights that would be off if it is a drag."""
    drag = left.profile
    if (
        drag is None
        or not left.is_real
        or (left.acts_as, left.follows) != DRAG_OVER_TIME
    ):
        return left
    return replace(left, heights=wander(engine, fit, drag, left.evidence, left.log))


def with_cut(left: Remainder, engine: Engine, fit: Fit, cause: Cause) -> Remainder:
    """Return what is left, or what a load had to leave that cannot be less than nil."""
    if not cause.cut:
        return left
    cuts, key = [left], cause.keys[0]
    probe = Probe(engine, fit, key)
    for i, beyond in cause.cut.items():
        x = engine.problems[i].coordinate(beyond.along)
        found = windows_of(probe, i, beyond, x)
        if found:
            acts = FEED if beyond.mean < 0 else ITSELF[cause.effect]
            nats, shares = cause.cut_nats, probe.shares
            one = Remainder(nats, acts, beyond.along, found, beyond, i, shares)
            cuts.append(replace(one, rivals=left.rivals))
    return clearest(cuts)


def inexactness(engine: Engine, fit: Fit) -> Array:
    """Return the nats of each track of which a model is not exact, as models go.

    EXACT² / 2 · |W (x - mean x)|², x being what is predicted and W whitening it.
    """
    nats = []
    for (log, channel), left, white in zip(
        engine.tracks, fit.residuals, fit.noise, strict=True
    ):
        predicted = engine.problems[log].log[channel] - left
        level = float(np.mean(predicted[white.valid])) if white.valid.any() else 0.0
        moves = np.nan_to_num(predicted - level)
        nats.append(0.5 * EXACT**2 * float((white(moves) ** 2).sum()))
    return np.array(nats)


def acting_as(engine: Engine, fit: Fit, name: str, key: str) -> list[Remainder]:
    """Return the likeliest form, or forms, of a way of acting, as one figure does."""
    probe = Probe(engine, fit, key)
    follows = OTHERS.get(name, FOLLOWS)
    if name != EFFICIENT:
        return [likeliest_of(probe, name, follows)]
    probe = probe.by(evenly(engine, fit, probe.tracks))
    # it may go by all of them at once; one that stays as it is has not to be unknown
    level = Knob(f"{key}.level", 0.0, inf)
    freed = probe.by(probe.fit.beside([(level, probe.signal)]))
    found = [likeliest_of(probe, name, {x: n}, freed) for x, n in follows.items()]
    return [as_warming(probe, r) if (name, r.follows) == WARMS else r for r in found]


def as_warming(probe: Probe, left: Remainder) -> Remainder:
    """Return an efficiency that changes over time beside the noise that it leaves."""
    if left.profile is None:
        return left
    x = probe.engine.problems[left.log].coordinate(left.follows)
    known = left.profile, left.evidence, left.log, x
    course, nats = warming(probe, *known, left.enough)
    return replace(left, evidence=nats, profile=course)


def evenly(engine: Engine, fit: Fit, tracks: Sequence[int]) -> Fit:
    """Return a fit whose figures are told in some tracks as an efficiency is.

    Else one that makes less of a logged speed's noise may move, where the efficiency
    takes its place: what both say of the noise would count for the efficiency.
    """
    if not any(p.drive.imposed for p in engine.problems):
        return fit
    signals = [
        [
            evened(engine.problems[log], np.nan_to_num(x)) if i in tracks else x
            for i, ((log, _), x) in enumerate(zip(engine.tracks, one, strict=True))
        ]
        for one in fit.signals
    ]
    return replace(fit, signals=signals)


def changing(engine: Engine, fit: Fit, name: str, knob: Knob) -> list[Remainder]:
    """Return how a figure of a cause that was taken as constant may change.

    A sensor's not with the steering: an offset that follows the steering is a gain.
    """
    probe = Probe(engine, fit, knob.key, knob.inward(fit.values[knob.key]))
    sensor = engine.vehicle.known[name].sensor
    follows = {x: n for x, n in CHANGES.items() if not (sensor and x == STEERING)}
    found = [likeliest_of(probe, name, {x: n}) for x, n in follows.items()]
    # in a bend, or just after braking, no torque is told well: that has to be real
    return [r for r in found if r.follows == "time_s" or r.evidence > UNKNOWN_ENOUGH]


def likeliest_of(
    probe: Probe,
    name: str,
    follows: Mapping[str, tuple[int, ...]],
    freed: Probe | None = None,
) -> Remainder:
    """Return the likeliest form of one way of acting.

    What it gains is that of a probe that is ``freed`` of something, where that is less.
    """
    best = Remainder(0.0, name, "", [], shares=probe.shares)
    for i, problem in enumerate(probe.engine.problems):
        for along, counts in follows.items():
            if along not in MODELLED and along not in problem.log:
                continue
            x = problem.coordinate(along)
            most = max(counts)
            if along == "time_s" and name != "grip":
                # no finer than the noise remembers
                most = max(int((x[-1] - x[0]) / MEMORY) + 1, counts[0])
            tried = [probe.profile(i, along, x, n) for n in counts if n <= most]
            if name == EFFICIENT:  # none goes up and down from one torque to the next
                tried = [p for p in tried if p.coherence >= TIED]
            profile = max(tried, key=lambda p: p.evidence, default=None)
            if profile is None or profile.evidence <= best.evidence:
                continue
            nats = profile.evidence
            if freed:
                again = freed.profile(i, along, x, len(profile.knots))
                nats = min(nats, again.evidence)
            if nats > best.evidence:
                found = windows_of(probe, i, profile, x)
                best = Remainder(nats, name, along, found, profile, i, probe.shares)
    return best


def restless(engine: Engine, fit: Fit, log: int) -> list[Remainder]:
    """Return the bursts of a log's cornering, as of an angle of the wheels."""
    by_track, found = bursts(engine, fit, log)
    nats = float(by_track.sum())
    shares = by_track / (nats or 1.0)
    return [Remainder(nats, "steer", "time_s", found, None, log, shares)]


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
    gap = 0.5 * (time[-1] - time[0]) / WINDOWS
    spans: list[list[int]] = []
    for a, b in zip(*runs(clear), strict=True):
        if spans and time[a] - time[spans[-1][1] - 1] < gap:
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
