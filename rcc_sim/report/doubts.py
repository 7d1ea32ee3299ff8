"""What a reader of a diagnosis should doubt: figures, sensors, logs, the vehicle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rcc_sim.analyse.gap_energy import COVERAGE
from rcc_sim.analyse.logcheck.finding import DROPPED
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.diagnose.judge.asserted import Asserted
from rcc_sim.diagnose.judge.direct import felt_otherwise
from rcc_sim.diagnose.judge.verdict import of_another
from rcc_sim.report.text import figures, listed, rounded, short
from rcc_sim.report.verdict import OTHER, doubt_of, hangs_together, too_many

SHOWN = 4
"""Figures, or logs, that are told at most."""

SURE = 0.9
"""Probability of a cause below which the verdict says that it is not for sure."""

OTHERWISE = (
    "another car, load, wind or road, or the way back (--back)? Diagnose it alone"
)
"""What may be with a log whose gap grows by what mends the others."""

OF_ITS_OWN = (
    "differs from log to log: a mended file states its mean, which suits none of them; "
    "what one log has of its own, as its load, its tyres or its road, would show so: "
    "diagnose each alone"
)
"""What is to be said of a cause that has another mean in each log."""

AS_A_DRAG = {
    "road_grade": "a drag or a wind that changes with time would do about as well as "
    "the slope: {}the way back (--back) tells them apart",
    "headwind": "a drag that changes with time, or a slope, would do about as well as "
    "the wind: an anemometer (headwind_mps) and the road's elevation tell them apart",
}
"""Cause that varies -> what may be in its place."""


CONTRADICTED = (
    *("misread", "late", "until", "wander", "may_wander", "disagrees"),
    *("opposed", "restless"),
    *("no_bends", "climb", "not_judged", "resistance"),
)
"""Kinds of findings that a fit has about a log."""


def doubts(found: Diagnosis) -> Iterator[tuple[str, str]]:
    """Yield the word at the left and what it says of what may be otherwise."""
    yield from moved_figures(found)
    for one in found.by_log:
        if one.disagrees:
            yield (
                "DOUBT",
                f"{short(one.log)} does not go with the others: energy gap "
                f"{rounded(one.before or 0.0, 1)} % before, "
                f"{rounded(one.after or 0.0, 1)} % after; {OTHERWISE}",
            )
    if not found.asserted:
        yield from one_parts(found)
    for a in filter(differs, found.asserted):
        yield "DOUBT", f"{a.cause.effect} {OF_ITS_OWN}"
    for a in filter(is_a_drag_as_well, found.asserted):
        if not felt_otherwise(a.cause, found.gap.findings):
            felt = "accel_x_mps2" in found.problem.channels
            more = "" if felt else "an accelerometer in the log, or "
            yield "DOUBT", AS_A_DRAG[a.cause.effect].format(more)
    yield from left_out(found)
    other = of_another(found.gap.findings)
    many = too_many({a.cause.effect: a.parameters for a in found.asserted})
    if other:
        yield "DOUBT", f"{other}: {OTHER}"
    if many:
        yield "DOUBT", many
    yield from misread_sensors(found)
    if not found.asserted:
        yield from sds_to_measure(found)
    restless = hangs_together({"mode": found.gap.mode, "foreseen": found.foreseen})
    if found.status == "no_gap" and restless:
        yield "DOUBT", restless


def left_out(found: Diagnosis) -> Iterator[tuple[str, str]]:
    """Yield the channels that no log was judged by, and what is wrong with them."""
    for gap in found.gaps:
        wrong = [f for f in gap.findings if f.action.startswith(DROPPED)]
        told = (f"{f.channel} {f.what.partition(' (')[0]}" for f in wrong[:SHOWN])
        if wrong:
            yield (
                "DOUBT",
                f"{short(gap.log)}: {listed([*told])}: left out, and nothing is judged "
                "by it; a --map mends it (rccsim check)",
            )


def differs(one: Asserted) -> bool:
    """Tell whether the mean of a cause that varies is another in each log for sure."""
    each = (x.each for x in one.figures.values() if x.each)
    return any(max(e.low for e in es) > min(e.high for e in es) for es in each)


def is_a_drag_as_well(one: Asserted) -> bool:
    """Tell whether a drag over time may be in the place of a hill, or of a wind."""
    varies = one.cause.effect in AS_A_DRAG and bool(one.cause.profiles)
    return varies and one.probability < SURE


def one_parts(found: Diagnosis) -> Iterator[tuple[str, str]]:
    """Logs that alone part from the model, where no cause would mend all of them."""
    off, fit = (
        [short(g.log) for g in found.gaps if g.energy.within is way]
        for way in (False, True)
    )
    if off and fit:
        yield (
            "DOUBT",
            f"the energy of {named(off)} is beyond its doubt, that of {named(fit)} is "
            f"not: {OTHERWISE}",
        )


def named(logs: Sequence[str]) -> str:
    """Return the names of some logs, the first of many."""
    more = len(logs) - SHOWN
    return listed([*logs[:SHOWN], f"{more} more"] if more > 0 else logs)


def moved_figures(found: Diagnosis) -> Iterator[tuple[str, str]]:
    """Stated figures that the logs moved farthest: from, to, in their sds."""
    stated, doubt = found.vehicle.figures(), ""
    if found.moved:
        told = (
            f"{key} {figures(stated[key].value, 4)} to "
            f"{figures(stated[key].value + x * stated[key].tolerance, 4)} "
            f"({rounded(x, 1)} sd)"
            for key, x in list(found.moved.items())[:SHOWN]
        )
        left = found.status == "unexplained" and not found.taken_up
        doubt = doubt_of(found.moved, found.moved_together, left=left)
        yield "MOVED", "; ".join(filter(None, (", ".join(told), doubt)))
    kept = found.kept_out
    if kept is not None and doubt:
        each = kept.values.items()
        values = ", ".join(f"{k.rpartition('.')[2]} {figures(x, 3)}" for k, x in each)
        yield (
            "DOUBT",
            f"{kept.effect} ({values}) may act in place of these shifts: it gains "
            f"{kept.nats:.0f} nats, where {kept.needed:.0f} are asked beside so strong "
            "a cause",
        )


def sds_to_measure(found: Diagnosis) -> Iterator[tuple[str, str]]:
    """Stated figures to measure where their sds alone allow the energy gap."""
    energy = found.gap.energy
    if not energy.within or abs(energy.gap_wh or 0.0) < COVERAGE * energy.noise_wh:
        return
    most = list(energy.by_figure.items())[:SHOWN]
    told = ", ".join(f"{key} {abs(wh):.3g} Wh" for key, wh in most)
    yield "DOUBT", f"the file's sds allow {energy.expanded:.3g} Wh; an sd of {told}"


def misread_sensors(found: Diagnosis) -> Iterator[tuple[str, str]]:
    """Sensors that the rest of the log contradicts, or that it would need."""
    for f in found.gap.findings:
        if f.kind in CONTRADICTED:
            yield "DOUBT", f"{f.channel} {f.what}; {f.action}"
