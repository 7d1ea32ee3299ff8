"""Causes that vary over a drive: looked for, window by window.

An effect's signal is what it adds to each channel. Times a window it is what the
effect adds if it acts in that window alone, because the vehicle, drawn to its log,
forgets within a second. The strengths in the windows are then a linear problem, with
a prior on their size and roughness that the log itself scales.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import replace
from functools import cached_property, partial
from math import inf

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from rcc_sim.definitions.vehicle import EFFICIENCY
from rcc_sim.diagnose.causes.cause import ENOUGH
from rcc_sim.diagnose.causes.profile import Profile, shares
from rcc_sim.diagnose.causes.strengths import (
    Prior,
    Weighed,
    Windows,
    freed,
    likeliest,
    prior_of,
    priors_of,
    windows,
)
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob, bounds_of
from rcc_sim.diagnose.noise.strips import Strips
from rcc_sim.diagnose.noise.whitener import (
    Whitener,
    fit_whitener,
    log_likelihood,
)
from rcc_sim.diagnose.residuals.losses import told
from rcc_sim.diagnose.residuals.sizes import small_changes
from rcc_sim.side_by_side import each
from rcc_sim.units import unit_of

Array = NDArray[np.float64]

DRIFTS = ("effects.auxiliary_load.power_w",)
"""What a slow drift of the battery's gauge looks the same as, and gives way to."""

ROUNDS, SETTLED = 4, 0.1
"""Rounds in which a profile and the noise find their shares, at most; and nats from
which on one that changes no more is the last: they decide nothing."""

RIDGE = 1e-6
"""Share of what a window tells that is added to each, where one tells nothing. [1]"""


class Probe:
    """The signal of one figure at a fit, ready to be cut into windows.

    By a step of it of some size; a small one where it is not given.
    """

    def __init__(
        self, engine: Engine, fit: Fit, key: str, size: float | None = None
    ) -> None:
        size = probe_size(engine, key) if size is None else size
        self.engine, self.fit, self.key = engine, fit, key
        self._without: dict[int, float] = {}
        self.base = base = fit.values.get(key, engine.stated(key))
        knob = Knob(key, base, inf, *bounds_of(engine.problems[0], key), step=size)
        values = fit.values | {key: base}
        (_, start), (size, moved) = each(
            lambda h: engine.aside(values, knob, h), [0.0, knob.inward(base)]
        )
        pairs = zip(moved, start, strict=True)
        per = 1 / size if size else 0.0  # at a bound on both sides
        self.signal = [np.nan_to_num(per * (a - b)) for a, b in pairs]
        if key == EFFICIENCY:
            tracks = zip(engine.tracks, self.signal, strict=True)
            self.signal = [told(engine.problems[i], x) for (i, _), x in tracks]
        self.tracks = [
            i for i, w in enumerate(fit.noise) if np.any(self.signal[i][w.valid])
        ]

    def as_if_none(self, acting: Mapping[int, Profile]) -> Probe:
        """Return it for the whole of what acts, as if nothing did: to first order.

        What is found anew is then linear about what acts, and not about nil.
        """
        strength = self._at_rows(acting)
        tracks = zip(self.engine.tracks, self.fit.residuals, self.signal, strict=True)
        left = [e - x * strength.get(i, 0.0) for (i, _), e, x in tracks]
        return self.by(replace(self.fit, residuals=left))

    def by(self, fit: Fit) -> Probe:
        """Return it by another fit of the same figures, with the same signal."""
        probe = copy(self)
        probe.fit, probe._without = fit, {}
        for of_the_fit in ("_beside", "_forgetful"):
            probe.__dict__.pop(of_the_fit, None)
        return probe

    @property
    def shares(self) -> Array:
        """Share of each track in the signal."""
        return shares(self.signal, self.fit.noise)

    def shares_of(self, profiles: Mapping[int, Profile]) -> Array:
        """Share of each track in what profiles change, log by log."""
        strength = self._at_rows(profiles)
        pairs = zip(self.engine.tracks, self.signal, strict=True)
        return shares([x * strength.get(i, 0.0) for (i, _), x in pairs], self.fit.noise)

    def _at_rows(self, profiles: Mapping[int, Profile]) -> dict[int, Array]:
        """Return the strength of profiles at the rows of their logs."""
        problems = self.engine.problems
        return {i: p.at(problems[i].coordinate(p.along)) for i, p in profiles.items()}

    def profile(self, log: int, along: str, x: Array, count: int) -> Profile:
        """Strengths over a coordinate x of one log, and the evidence for them."""
        knots = np.linspace(x.min(), x.max(), count)
        tracks = self._tracks_of(log)
        if not tracks or knots[0] == knots[-1]:
            return Profile(self.key, along, knots, 0 * knots, 0 * knots, 0.0)
        H = windows(x, knots)
        noise = [self.fit.noise[i] for i in tracks]
        prior = prior_of(self.key, along, knots)
        found = self._weighed(tracks, H, noise, self._left(tracks), prior)
        drifts = self.key not in DRIFTS and any(w.drift is not None for w in noise)
        if drifts:
            found = self._relearnt(tracks, H, found, prior)
        return Profile(
            self.key,
            along,
            knots,
            found.value,
            found.sd,
            found.evidence,
            drifts,
            None if drifts else found.normal,
            prior.held,
            found.mean_sd,
        )

    def sharper(
        self, profile: Profile, log: int, x: Array, counts: Iterable[int]
    ) -> Profile:
        """The same by the noise that it leaves: sharper, and no likelier for it."""
        return self.sharpest(profile, log, x, counts)[0]

    def sharpest(
        self, profile: Profile, log: int, x: Array, counts: Iterable[int]
    ) -> tuple[Profile, float]:
        """A profile by the noise that it leaves, and the evidence for both together.

        In more windows where they gain ``ENOUGH``, as gentle as is likeliest. What
        varies fast passes for a noise that remembers, which smooths it away: the noise
        is learnt from that of the fit, and from one that remembers nothing.
        """
        if profile.normal is None or profile.evidence <= 0:
            return profile, profile.evidence
        best, most = profile, profile.evidence
        for n in sorted(counts):
            knots = np.linspace(x.min(), x.max(), n)
            H, finer = windows(x, knots), n > len(best.knots)
            ways = [
                partial(self._beside_noise, log, H, prior, forgetful)
                for prior in priors_of(profile.key, profile.along, knots)
                for forgetful in (False, True)
            ]
            tried = each(lambda way: way(), ways)
            found = max(tried, key=lambda one: one.evidence)
            if found.evidence > most + (ENOUGH if finer else 0.0):
                most = found.evidence
                best = replace(
                    profile,
                    knots=knots,
                    value=found.value,
                    sd=found.sd,
                    mean_sd=found.mean_sd,
                )
        return best, most

    def with_noise(self, profile: Profile, log: int, x: Array) -> float:
        """Evidence for a profile and the noise that it leaves, together. [nats]

        What switches on and off passes for a noise that remembers: by that noise it
        gains next to nothing.
        """
        if not self.shows_in(log):
            return 0.0
        prior = prior_of(profile.key, profile.along, profile.knots)
        return self._beside_noise(log, windows(x, profile.knots), prior).evidence

    def per_row(self, log: int, *, scaled: bool = False) -> tuple[Array, Array]:
        """Likeliest strength row by row, and how much each tells (inverse variance).

        By a noise that remembers nothing; the same in all rows, or ``scaled`` as it
        grows, but nowhere less than usual: where a vehicle stands it is still, and what
        a model errs by as it moves off would count for all.
        """
        told = np.zeros(len(self.engine.problems[log].log["time_s"]))
        asked = np.zeros_like(told)
        for i in self._tracks_of(log):
            w = self._forgetful[i]
            v, scale = w.valid, np.ones(len(told))
            if scaled:
                scale = np.maximum(w.scale, np.median(w.scale[v]))
            signal = self.signal[i] / (scale * w.sigma) ** 2
            asked[v] -= (signal * self.fit.residuals[i])[v]
            told[v] += (signal * self.signal[i])[v]
        return asked / np.maximum(told, 1e-300), told

    def beside_noise(
        self, log: int, H: Windows, shape: Array, *, begun: bool = False
    ) -> Weighed:
        """Strengths in windows H (n, k), by the ``shape`` of their prior.

        Weighed against the noise, from one that remembers nothing: what switches, or
        grows without haste, passes for one that does. What noise and knobs gain without
        them, found anew as well, is no evidence for them. From those of least squares
        by that noise, and from what these leave, where it is ``begun`` so.
        """
        prior = Prior(shape)
        if begun:
            found = self._begun(log, H, prior)
        else:
            found = self._beside_noise(log, H, prior, forgetful=True)
        return replace(found, evidence=found.evidence - self.without(log))

    def without(self, log: int) -> float:
        """Evidence for noise and knobs found anew, without any strength. [nats]"""
        if log not in self._without:
            rows = len(self.engine.problems[log].log["time_s"])
            none = csc_array((rows, 1)), Prior(np.eye(1))
            nothing = self._beside_noise(log, *none, forgetful=True)
            self._without[log] = nothing.evidence
        return self._without[log]

    def _beside_noise(
        self, log: int, H: Windows, prior: Prior, forgetful: bool = False
    ) -> Weighed:
        """Strengths by the noise that they leave, learnt from that of the fit.

        Or from one that remembers nothing (``forgetful``).
        """
        tracks = self._tracks_of(log)
        known = self._forgetful if forgetful else self.fit.noise
        noise = [known[i] for i in tracks]
        return self._together(tracks, H, noise, self._left(tracks), prior)

    def _begun(self, log: int, H: Windows, prior: Prior) -> Weighed:
        """Strengths by the noise that they leave, from those of least squares."""
        value, told = self.per_row(log, scaled=True)
        tracks, G = self._tracks_of(log), (H.T @ H.multiply(told[:, None])).toarray()
        ridge = RIDGE * np.trace(G) / len(G) * np.eye(len(G))
        start = np.linalg.solve(G + ridge, H.T @ (told * value))
        left = [
            e + self.signal[i] * (H @ start)
            for e, i in zip(self._left(tracks), tracks, strict=True)
        ]
        noise = self.engine.learn_noise_of(tracks, left)
        return self._together(tracks, H, noise, left, prior)

    def _together(
        self,
        tracks: list[int],
        H: Windows,
        noise: list[Whitener],
        left: list[Array],
        prior: Prior,
    ) -> Weighed:
        """Strengths weighed by a noise, and then against the noise that they leave."""
        found = self._weighed(tracks, H, noise, left, prior)
        return self._relearnt(tracks, H, found, prior)

    def evidence(self, log: int, H: Windows, shape: Array) -> float:
        """Evidence for such strengths by the noise of the fit. [nats]"""
        tracks = self._tracks_of(log)
        noise = [self.fit.noise[i] for i in tracks]
        left = self._left(tracks)
        return self._weighed(tracks, H, noise, left, Prior(shape)).evidence

    @cached_property
    def _forgetful(self) -> dict[int, Whitener]:
        """Noise of each track that remembers nothing, but grows as the fit's does."""
        fit, grows = self.fit, self.engine.grows_with
        return {
            i: fit_whitener(fit.residuals[i], fit.noise[i].valid, grows[i], [])
            for i in self.tracks
        }

    def shows_in(self, log: int) -> bool:
        """Tell whether the figure changes anything that a log holds."""
        return bool(self._tracks_of(log))

    def _tracks_of(self, log: int) -> list[int]:
        return [i for i in self.tracks if self.engine.tracks[i][0] == log]

    def _left(self, tracks: list[int]) -> list[Array]:
        return [self.fit.residuals[i] for i in tracks]

    @cached_property
    def _beside(self) -> tuple[Array, Array]:
        """What other channels say of the knobs: rows R (m, k) and s (m,), as R x + s.

        Without them knobs that turn a vehicle would give way for nothing, and a hill
        take what it costs to turn.
        """
        fit, own = self.fit, set(self.tracks)
        others = [i for i, w in enumerate(fit.noise) if i not in own and w.valid.any()]
        if not others:
            return np.zeros((0, len(fit.knobs))), np.zeros(0)
        R, s = zip(*map(fit.told_by, others), strict=True)
        return np.vstack(R), np.concatenate(s)

    def _weighed(
        self,
        tracks: list[int],
        H: Windows,
        noise: list[Whitener],
        left: list[Array],
        prior: Prior,
    ) -> Weighed:
        """Strengths in some windows, by a noise and what is left to weigh rows by."""
        fit = self.fit
        A = Strips.stacked(
            [w.through(self.signal[i], H) for w, i in zip(noise, tracks, strict=True)]
        )
        by = [fit.weighted(*one) for one in zip(tracks, noise, left, strict=True)]
        A = A.times(np.concatenate([rows.root for rows in by]))
        r = np.concatenate([rows.residual for rows in by])
        J = np.vstack([rows.signals for rows in by])
        M, b, back = freed(A, r, J, fit.prior_sd, fit.off, self._beside)
        evidence, value, sd, mean_sd = likeliest(M, b, prior, H.mean(axis=0))
        cost = float(b @ value - 0.5 * value @ M @ value) - evidence
        return Weighed(evidence, value, sd, back(value), cost, (M, b), mean_sd)

    def _relearnt(
        self, tracks: list[int], H: Windows, found: Weighed, prior: Prior
    ) -> Weighed:
        """Weigh a profile against the noise, as either may be taken for the other.

        The noise is learnt anew from what the profile leaves. The evidence is the
        likelihood of that, by that noise, to the likelihood of all by its own.
        """
        fit = self.fit
        sd, off = fit.prior_sd, fit.off
        R, s = self._beside
        all_in = sum(log_likelihood(fit.noise[i], fit.residuals[i]) for i in tracks)
        best = replace(found, evidence=0.0, value=0 * found.value)
        now, last = found, inf
        for _ in range(ROUNDS):
            left = [
                fit.residuals[i]
                + self.signal[i] * (H @ now.value)
                + fit.signals_in(i) @ now.knobs
                for i in tracks
            ]
            noise = self.engine.learn_noise_of(tracks, left)
            now = self._weighed(tracks, H, noise, left, prior)
            likely = sum(log_likelihood(w, e) for w, e in zip(noise, left, strict=True))
            pull = 0.5 * float((((off + now.knobs) / sd) ** 2 - (off / sd) ** 2).sum())
            pull += 0.5 * float(((s + R @ now.knobs) ** 2 - s**2).sum())
            now = replace(now, evidence=likely - all_in - pull - now.cost)
            if now.evidence > best.evidence:
                best = now
            if abs(now.evidence - last) < SETTLED:
                break
            last = now.evidence
        return best


def probe_size(engine: Engine, key: str) -> float:
    """A small change of a figure, for a vehicle of any size."""
    return small_changes(engine.problems[0]).get(unit_of(key), 0.005)
