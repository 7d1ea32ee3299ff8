"""Null, single effects and sets of them compete for one log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rcc_sim.diagnose.candidates import Candidate, candidates_for
from rcc_sim.diagnose.fit import Engine, Fit, Knob, bias_knobs, tolerance_knobs
from rcc_sim.diagnose.search import Screen

REFINED = 6
ENOUGH = 15.0
MISFIT = 0.003


@dataclass
class Hypothesis:
    effects: tuple[Candidate, ...]
    fit: Fit

    @property
    def names(self):
        return tuple(c.effect for c in self.effects)


def effect_knobs(candidate: Candidate, values) -> list[Knob]:
    out = []
    for s in candidate.searches:
        x = values.get(s.key, s.neutral)
        if not np.isfinite(x):
            x = 2 * max(s.grid) if s.grid else s.first
        step = (
            0.02 * abs(x - s.neutral)
            if np.isfinite(s.neutral) and x != s.neutral
            else 0.02 * abs(x)
        )
        step = step or 0.02 * abs(s.first)
        out.append(Knob(s.key, x, np.inf, s.low, s.high, step=step))
    return out


def nuisance(problem) -> list[Knob]:
    knobs = tolerance_knobs(problem) + bias_knobs(problem)
    if not problem.drive.imposed and "motor_lag" not in problem.vehicle.effects:
        knobs.append(
            Knob("effects.motor_lag.time_constant_s", 0.0, 0.003, 0.0, 1.0, step=0.001)
        )
    return knobs


def with_effect(engine, base: Fit, candidate: Candidate, values, J, noise, rounds=6) -> Fit:
    """Refine a screened candidate under given noise, the other knobs moving along J."""
    mine = [k for k in effect_knobs(candidate, values) if k.key in values]
    keys = {k.key for k in mine}
    kept = [(i, k) for i, k in enumerate(base.knobs) if k.key not in keys]
    knobs = [k for _, k in kept] + mine
    fixed = J[[i for i, _ in kept]]
    now = engine.evaluate(base.values | values, knobs, noise)
    for _ in range(rounds):
        S = np.concatenate([fixed, engine.signals(now.values, mine, now.residual)])
        new = engine.fit(now.values, knobs, noise=noise, signals=S, rounds=1)
        gain = new.score - now.score
        now = new
        if gain < 0.5:
            break
    return now


PRIOR = {"iron_loss": -4.0}


def compete(engine: Engine):
    problem = engine.problem
    base = engine.fit({}, nuisance(problem))
    cands = candidates_for(problem)
    chain = []
    current, names = base, ()
    for depth in range(3):
        J, noise = current.signals, current.whiteners
        screen = Screen(engine, current, current.knobs, J)
        free = [c for c in cands if c.effect not in names]
        found = sorted(engine.pool.map(screen.screen, free), key=lambda r: -r.gain)
        found = [r for r in found[:REFINED] if r.gain > 1]
        fits = list(engine.pool.map(lambda r: with_effect(engine, current, r.candidate, r.values, J, noise), found))
        if not fits:
            break
        first = [round(f.score - current.score + PRIOR.get(r.candidate.effect, 0), 1) for f, r in zip(fits, found)]
        winner = max(range(len(fits)), key=lambda i: first[i])
        noise = engine.noise(fits[winner].residual)
        again = engine.fit(current.values, list(current.knobs), noise=noise, rounds=3, signals=J)
        fits = list(engine.pool.map(lambda rf: with_effect(engine, again, rf[0].candidate, {k: rf[1].values[k] for k in rf[0].values}, J, noise), zip(found, fits)))
        second = [round(f.score - again.score + PRIOR.get(r.candidate.effect, 0), 1) for f, r in zip(fits, found)]
        order = sorted(range(len(fits)), key=lambda i: -second[i])
        chain.append([(found[i].candidate.effect, round(found[i].gain), first[i], second[i], {k.split(".")[-1]: float("%.4g" % fits[i].values[k]) for k in found[i].values}) for i in order])
        best = order[0]
        if depth == 0:
            most = second[best]
        if min(second[best], first[best]) < ENOUGH or second[best] < MISFIT * most:
            break
        names += (found[best].candidate.effect,)
        current = engine.fit(fits[best].values, list(fits[best].knobs))
    return base, names, current, chain
