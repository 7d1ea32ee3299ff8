"""A delay that the log shows without any noise model, weighed before all else."""

from __future__ import annotations

from collections.abc import Sequence

from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.cause import ENOUGH
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.search.pursue import effect_knobs
from rcc_sim.diagnose.search.refine import Refined, handicap
from rcc_sim.diagnose.search.screen import Screened


def read_late(
    engine: Engine, null: Fit, candidates: Sequence[Candidate]
) -> Refined | None:
    """Return a delay that was measured beside the drive, if the logs ask for it.

    What is late by some rows leaves a residual that its own past foresees, as noise
    that remembers does: by the noise that tolerances alone leave, no delay gains. Each
    is weighed by its own, from what the file states: tolerances that stood in for it
    need not find back.
    """
    tried = (
        Screened(candidate, 0.0, {search.key: search.grid[0]})
        for candidate in candidates
        for search in candidate.searches
        if search.measured
    )
    best: Refined | None = None
    for one in tried:
        knobs = [*null.knobs, *effect_knobs(one)]
        fit = descent.fit(engine, one.values, knobs)
        gain = fit.score - null.score - handicap(one, fit.values)
        if gain > (best.gain if best else ENOUGH):
            best = Refined(one, fit, gain, gain)
    return best
