"""What stands after its proof: causes that rows, or logs, that no fit saw refute."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from rcc_sim.analyse.gap import Gap
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.judge.asserted import estimates
from rcc_sim.diagnose.judge.energies import (
    SHRUNK,
    proves_nothing,
    stays_off,
    worsens,
)
from rcc_sim.diagnose.judge.stands import Standing, only
from rcc_sim.diagnose.proof.by_log import LogEnergy, each_log, noise_of
from rcc_sim.diagnose.proof.hold_out import Proof, leave_shaft, proof
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.search.compete import Explanation


@dataclass(frozen=True)
class Proven:
    """What stands, and what rows that no fit saw say of it.

    Parameters
    ----------
    stands : Standing
        No cause where they are refuted.
    proof : Proof
        What it does there.
    refuted : tuple of str
        Effects that stood before.
    unproven : bool
        What it does for those rows may be nothing, or leaves their energy as it was:
        it is not what acts, or not all.
    by_log : tuple of LogEnergy
        Energy gap of each log, before and after, where there are several.
    """

    stands: Standing
    proof: Proof
    refuted: tuple[str, ...]
    unproven: bool
    by_log: tuple[LogEnergy, ...]


def proven(
    engine: Engine,
    found: Explanation,
    stands: Standing,
    gaps: Sequence[Gap],
    fresh: Sequence[Problem],
    stated: Mapping[str, float],
    *,
    doubtless: bool,
) -> Proven:
    """Return what stands, without the causes if they are refuted.

    By the logs kept back (``fresh``), else by stretches of those that were fitted.
    ``engine`` holds the logs without a profile; ``doubtless`` is an energy gap.
    """
    torqued = any(p.torqued for p in (*engine.problems, *fresh))
    by_torque = torqued and leave_shaft(stands.causes, stands.engine.tracks)
    how = partial(
        proof, nominal=engine, null=found.null, holdouts=fresh, by_torque=by_torque
    )
    by_log = partial(each_log, gaps, engine, by_torque=by_torque)
    level = levels_of(stands.causes, stands.fit, stated)
    proved = how(stands.engine, fit=stands.fit, level=level)
    refuted: tuple[str, ...] = ()
    varies = not fresh and any(c.over_time for c in stands.causes)
    refuting = is_refuted(
        stands.causes, proved, gaps, doubtless=doubtless, elsewhere=bool(fresh)
    )
    if refuting or (varies and opens_gaps(by_log(stands.engine, stands.fit))):
        refuted = tuple(c.effect for c in stands.causes)
        stands = only(engine, found, stands, [])
        proved = how(stands.engine, fit=stands.fit, level={})
    unproven = not fresh and proved.shrink.may_be_none
    unproven |= not fresh and rests_on_a_course(stands, proved)
    unproven |= stays_off(
        proved.before, proved.after, noise_of(gaps), doubtless=doubtless
    )
    each = by_log(stands.engine, stands.fit) if len(gaps) > 1 else ()
    return Proven(stands, proved, refuted, unproven, each)


def is_refuted(
    causes: Sequence[Cause],
    proved: Proof,
    gaps: Sequence[Gap],
    *,
    doubtless: bool,
    elsewhere: bool,
) -> bool:
    """Tell whether rows that no fit saw refute some causes.

    Where a gap is ``doubtless`` they do nothing for it there; nor does a profile,
    though it was fitted there too. Or they open one, which what each drive has of its
    own may, being another on rows held out. What was found beside a gauge that drifts
    is not refuted by an energy that the drift takes, nor a hill by rows of a drive
    ``elsewhere``, which may go over another road.
    """
    if all(is_beside_drift(c) for c in causes):
        return False
    if elsewhere and all(c.along_way for c in causes):
        return False
    before, after = proved.before, proved.after
    asked = doubtless or any(c.profiles for c in causes)
    if asked and proves_nothing(proved.shrink.explained, before, after):
        return True
    steady = not any(c.over_time for c in causes)
    return steady and worsens(before, after, noise_of(gaps))


def rests_on_a_course(stands: Standing, proved: Proof) -> bool:
    """Tell whether what varies shrinks little on held-out rows beyond their energy.

    Its course was fitted to these as well, and their energy is its own then. Of drives
    by commands: one by its measured motion has its speed's noise in all that is left.
    """
    varies = any(c.profiles for c in stands.causes)
    imposed = all(p.drive.imposed for p in stands.engine.problems)
    return varies and not imposed and proved.shrink.explained < SHRUNK


def is_beside_drift(cause: Cause) -> bool:
    """Tell whether a cause varies, and was weighed beside the drift of a gauge."""
    return bool(cause.profiles) and all(p.beside_drift for p in cause.profiles.values())


def opens_gaps(by_log: Sequence[LogEnergy]) -> bool:
    """Tell whether causes open an energy gap in every log that they were fitted to.

    One that varies may follow row by row what another does, and miss what all takes.
    """
    return all(one.disagrees for one in by_log)


def levels_of(
    causes: Sequence[Cause], fit: Fit, stated: Mapping[str, float]
) -> dict[str, float]:
    """Return the mean of what varies over time, as the mended file states it."""
    return {
        cause.keys[0]: next(iter(estimates(fit, cause, stated).values())).value
        for cause in causes
        if cause.over_time
    }
