"""Whether a cause stands beside an efficiency that goes by torque or speed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from rcc_sim.definitions.vehicle import EFFICIENCY
from rcc_sim.diagnose.causes.cause import ENOUGH, Cause
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.causes.strengths import prior_of, smooth, windows
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit, Free, of_unit_diagonal
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.noise.whitener import weights
from rcc_sim.diagnose.profiles.forms import EFFICIENT
from rcc_sim.diagnose.profiles.probe import Probe
from rcc_sim.diagnose.profiles.remainder import Remainder
from rcc_sim.diagnose.profiles.varying import held

MOSTLY = 0.5
"""Share of what a cause gains that it must gain beside an efficiency, too. Of eleven
loads that vary, five of them measured heaters, each gains 0.97 to 1.05 of it."""


def beside_losses(
    engine: Engine,
    fit: Fit,
    causes: Sequence[Cause],
    left: Remainder,
    *,
    acting: bool,
) -> Remainder:
    """Return what is left, with the effects that stand beside an efficiency in it.

    What a motor loses goes by its torque, or its speed: a load, a hill or a wind may be
    there as well. A cause stands if it gains most of its nats, and as many as a cause
    must, where the efficiency may take its part. ``acting``: courses act on the
    engine's logs already.
    """
    losses = [r.profile for r in left.rivals if r.acts_as == EFFICIENT and r.profile]
    if not losses:
        return left
    free = courses(engine, fit, losses)
    stand = (c.effect for c in causes if stands(engine, fit, c, free, acting))
    return replace(left, apart=frozenset(stand))


def stands(engine: Engine, fit: Fit, cause: Cause, free: Free, acting: bool) -> bool:
    """Tell whether a cause gains most of its nats beside some courses."""
    if not cause.profiles:
        nats = constant_nats(engine, fit, fit, cause.keys)
        beside = constant_nats(engine, fit, fit.beside(free), cause.keys)
    else:
        key = cause.keys[0]
        probe = Probe(engine, held(fit, key), key)
        if acting:
            probe = probe.as_if_none(cause.profiles)
        nats = nats_of(probe, cause)
        beside = nats_of(probe.by(probe.fit.beside(free)), cause)
    return beside >= max(ENOUGH, MOSTLY * nats)


def courses(engine: Engine, fit: Fit, losses: Iterable[Profile]) -> Free:
    """Return what an efficiency may do that goes in all logs as any of some courses.

    Of each is known how large it is, and how little it changes from knot to knot: it is
    Z z, with z independent of each other and of sd 1.
    """
    tracks = list(
        zip(engine.tracks, Probe(engine, fit, EFFICIENCY).signal, strict=True)
    )
    free = []
    for n, course in enumerate(losses):
        Z = course.rms * np.linalg.inv(np.linalg.cholesky(smooth(len(course.knots)))).T
        x = [p.coordinate(course.along) for p in engine.problems]
        acts = [windows(each, course.knots) @ Z for each in x]
        for j in range(len(Z)):
            signal = [e * acts[i][:, j] if e.any() else e for (i, _), e in tracks]
            free.append((Knob(f"course.{n}.{j}", 0.0, 1.0), signal))
    return free


def constant_nats(engine: Engine, fit: Fit, wide: Fit, keys: Sequence[str]) -> float:
    """Nats of some figures of a fit where all that ``wide`` moves is free.

    ½ x' (C + S)⁻¹ x, with x their distance from what the file states, C its covariance
    after one Gauss-Newton step, and S what the file says that it may be (Wald's test).
    """
    mine = [i for i, k in enumerate(wide.knobs) if k.key in keys]
    precision = 1 / wide.prior_sd**2
    N, g = np.diag(precision), precision * wide.off
    for i, white in enumerate(fit.noise):  # by tracks: a log may last for hours
        J = white(wide.signals_in(i))
        r = white(fit.residuals[i])
        W = weights(r)
        N, g = N + J.T @ (W[:, None] * J), g + J.T @ (W * r)
    scaled, unit = of_unit_diagonal(N)
    C = np.outer(unit, unit) * np.linalg.inv(scaled)
    x = wide.off - C @ g
    stated, named = engine.vehicle.figures(), [wide.knobs[i] for i in mine]
    S = [stated[k.key].tolerance ** 2 if k.key in stated else 0.0 for k in named]
    x = x[mine] + [k.value - engine.stated(k.key) for k in named]
    return 0.5 * float(x @ np.linalg.solve(C[np.ix_(mine, mine)] + np.diag(S), x))


def nats_of(probe: Probe, cause: Cause) -> float:
    """Nats of courses at the knots of those of a cause."""
    nats = 0.0
    for i, p in cause.profiles.items():
        if not probe.shows_in(i):
            continue
        H = windows(probe.engine.problems[i].coordinate(p.along), p.knots)
        prior = prior_of(p.key, p.along, p.knots)
        if p.weighed:
            nats += probe.beside_noise(i, H, prior.shape).evidence
        else:
            nats += probe.evidence(i, H, prior.shape)
    return nats
