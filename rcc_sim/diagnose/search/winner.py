"""What won a turn of the competition, as a cause."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.profile import shares
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.noise.whitener import Whitener
from rcc_sim.diagnose.search.refine import Refined
from rcc_sim.diagnose.search.screen import Screened, shared
from rcc_sim.errors import InputError

Array = NDArray[np.float64]


def cause_of(engine: Engine, best: Refined, noise: list[Whitener]) -> Cause:
    """Return the winner as a cause; what ties with it is told once all are known.

    Where it acts is by the noise by which others are weighed against it.
    """
    keys = tuple(best.screened.values)
    return Cause(
        best.screened.candidate.effect,
        keys,
        best.gain,
        eased=max(best.eased, 0.0),
        sharpened=max(best.after / best.gain, 1.0) if best.gain > 0 else 1.0,
        shares=shares_of(engine, best.fit, keys, noise),
    )


def near_to(one: Cause, held: Mapping[str, float], known: Sequence[Screened]) -> Cause:
    """Return a cause with the nats that others gained, or would to first order."""
    own = held.get(one.effect, 0.0)
    slopes = {effect: x * own for effect, x in shared(known, one.effect).items()}
    most = {e: max(slopes.get(e, 0.0), held.get(e, 0.0)) for e in (*held, *slopes)}
    return replace(one, screened=most)


def shares_of(
    engine: Engine, fit: Fit, keys: Sequence[str], noise: list[Whitener]
) -> Array:
    """Share of each track in what some figures of a fit change together."""
    without = {k: x for k, x in fit.values.items() if k not in keys}
    try:
        pairs = zip(engine.residuals(without), fit.residuals, strict=True)
        changed = [np.nan_to_num(a - b) for a, b in pairs]
    except InputError:  # another cause acts through it: to first order
        own = [j for j, k in zip(fit.signals, fit.knobs, strict=True) if k.key in keys]
        changed = [np.nan_to_num(sum(of)) for of in zip(*own, strict=True)]
    return shares(changed, noise)
