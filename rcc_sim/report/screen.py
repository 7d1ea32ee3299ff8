"""A diagnosis on one screen of a terminal."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Mapping

import numpy as np

from rcc_sim.analyse.gap_energy import COVERAGE, EnergyGap, logged_power
from rcc_sim.analyse.logcheck.finding import counted
from rcc_sim.channel import moving_mean
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.diagnose.judge.asserted import Asserted, Estimate
from rcc_sim.diagnose.judge.chances import EVEN
from rcc_sim.diagnose.judge.energies import grew
from rcc_sim.diagnose.judge.verdict import UNSURE
from rcc_sim.diagnose.next_run.menu import STAND
from rcc_sim.report.channels import mend_of, way_of
from rcc_sim.report.doubts import SURE, doubts
from rcc_sim.report.html_parts import METERS, OR_TIE, OTHER_DRIVE, OTHERS, SHIFTS, SMALL
from rcc_sim.report.promise import promise
from rcc_sim.report.text import (
    figures,
    listed,
    percent,
    printable,
    probable,
    rounded,
    short,
    sparkline,
)
from rcc_sim.report.verdict import (
    DOUBTFUL,
    OTHER,
    TAKEN_UP,
    closes,
    in_its_place,
    is_at_bound,
    judged,
    off_by,
    takes_it_up,
    these,
    unaccounted,
)

WORDS = {
    "no_gap": "no gap beyond what tolerances and noise explain",
    "explained": "explained",
    "partly_explained": "partly explained",
    "unexplained": "a real gap",
}

RARE = "19 of 20 sound drives are less far off in energy: one more drive would tell"
"""What an energy gap beyond its expanded uncertainty is where no cause stands."""

UNIT = re.compile(r"(?<=\d) (?=(?:%|Wh|W|s|nats)\b|%)")
"""The blank before a unit, at which no line is broken."""

MARGIN = 9
"""Columns of the word at the left."""

LEAST_BARS, MOST_BARS = 15, 60
"""Columns that a line of bars takes."""

STEPS = 4
"""Times at most at which a cause goes from low to high, or back, that are told."""

SHOWN = 4
"""Logs, kinds of driving and stretches that are told at most."""

UNSEEN = 6
"""Effects that would not show, of which so many are told."""

GIVEN = {STAND: "its log as --on-stand"}
"""How the log of a run is given that was not driven on the road."""

RUNS = 3
"""Runs to drive next that are told."""

RIVALS = 3
"""Rivals that are told at most."""


def screen(found: Diagnosis, width: int = 80) -> list[str]:
    """Return the lines of the human output, none wider than ``width``.

    Names from files are told without control characters.
    """
    lines: list[str] = []
    for word, text in _told(found, min(width - MARGIN, MOST_BARS)):
        whole = textwrap.wrap(
            UNIT.sub("\u00a0", f"{word:<{MARGIN}}{printable(text)}"),
            max(width, 2 * MARGIN),
            subsequent_indent=" " * MARGIN,
            break_on_hyphens=False,
            drop_whitespace=True,
        )
        lines += [line.replace("\u00a0", " ") for line in whole or [word]]
    return lines


def _told(found: Diagnosis, room: int) -> Iterator[tuple[str, str]]:
    """Yield the word at the left and what it says."""
    yield from _gap(found)
    several = len(found.gaps) > 1

    def of(log: str) -> str:
        return f"{short(log)}: " if several else ""

    of_one = of(found.gap.log)
    bars = _bars(found, room)
    if bars:
        yield "OVER", f"{of_one}gap of the battery power, {bars[0]}"
        yield "", bars[1]
    regimes = [r for r in found.gap.regimes if r.gap_wh is not None]
    regimes = sorted(regimes, key=lambda r: -abs(r.gap_wh or 0.0))[:SHOWN]
    if regimes:
        told = (f"{r.regime.replace('_', ' ')} {_wh(r.gap_wh)}" for r in regimes)
        yield "WHERE", of_one + ", ".join(told)
    doubtful = [*doubts(found)]
    whose = f"; {OTHER}" * any(OTHER in why for _, why in doubtful)
    yield "VERDICT", _verdict(found) + whose
    for a in found.asserted:
        yield "CAUSE", _cause(a, len(found.gaps))
        yield from (("", text) for text in _each(found, a))
        yield from (("", text) for text in _steps(found, a))
    if found.withdrawn:
        yield (
            "AGAINST",
            f"{', '.join(found.withdrawn)}: of use on the rows fitted, of none on "
            f"{_held_out(found)}: withdrawn",
        )
    yield from _rivals(found)
    if found.asserted or found.taken_up:
        yield from _proof(found)
    elif found.kept_back:
        yield "PROOF", f"there is no cause to hold against {_held_out(found)}"
    yield from ((word, of_one + text) for word, text in _ledger(found))
    yield from doubtful
    if found.left.is_real:
        left = found.left
        course = left.profile.document() if left.profile else None
        yield (
            "LEFT",
            f"{of(found.gaps[left.log].log)}acts as {way_of(left.acts_as, course)}, "
            f"follows {left.follows} ({left.evidence:.0f} nats)"
            + ", at " * bool(left.windows)
            + ", ".join(
                f"{w['start_s']:.1f} to {w['end_s']:.1f} s"
                for w in left.windows[:SHOWN]
            )
            + "".join(f"; --candidates {name} asks for that" for name in found.may_be)
            + (f"; {mend}" if (mend := mend_of(left.acts_as, left.follows)) else ""),
        )
    unseen = found.not_identifiable
    if unseen:
        more = f", and {len(unseen) - UNSEEN} more" if len(unseen) > UNSEEN else ""
        least = found.found.least_seen
        weak = ", ".join(n + _from(least.get(n, {})) for n in unseen[:UNSEEN])
        yield "UNSEEN", f"would not show at a likely size: {weak}{more}"
    for one in found.experiments[:RUNS]:
        how = f" ({GIVEN[one.run.where]})" if one.run.where in GIVEN else ""
        yield "NEXT", f"{one.do}{how}, {one.time_s:.0f} s: {promise(one.document())}"
    if found.is_tied and not found.experiments:
        yield "NEXT", "no run of the menu would part what is tied"


def _from(least: Mapping[str, float | None]) -> str:
    """Return from what change on an effect would show; of a limit, up to what."""
    told = [
        f" ({k} {'up to' if k.startswith('max_') else 'from'} {figures(x, 2)})"
        for k, x in least.items()
        if x is not None
    ]
    return told[0] if told else ""


def _no_gap(found: Diagnosis) -> str:
    names = list(dict.fromkeys(c.channel for g in found.gaps for c in g.channels))
    measured = [g.energy.measured_wh for g in found.gaps]
    return "no gap" + judged(names, next((m for m in measured if m is not None), None))


def _gap(found: Diagnosis) -> Iterator[tuple[str, str]]:
    for gap in found.gaps[:SHOWN]:
        e = gap.energy
        text = f"{found.vehicle.name} on {gap.log}, {gap.mode}"
        if e.gap_wh is not None and e.gap_percent is not None:
            place = "battery" if e.at == "battery" else "shaft"
            text += (
                f": {place} energy {rounded(e.gap_percent, 1)} % ({_wh(e.gap_wh)} of "
                f"{e.measured_wh:.4g}), {_within(e)}"
            )
        yield "GAP", text
    if len(found.gaps) > SHOWN:
        yield "", f"and {counted(len(found.gaps) - SHOWN, 'more log')}"


def _within(e: EnergyGap) -> str:
    """Return an energy gap's doubt, and whether it is more than that."""
    told = f"u_val {figures(e.u_val, 2)} Wh"
    if e.within is None:
        return told
    return f"{told}: {'within' if e.within else 'beyond'} {COVERAGE:g} of them"


def _verdict(found: Diagnosis) -> str:
    """Return the status, and why there is a cause where the energy asks for none."""
    energies = [g.energy.within for g in found.gaps]
    told = WORDS[found.status].replace("no gap", _no_gap(found))
    if found.status == "unexplained":
        told += f" that {unaccounted(found.asked)}"
    why = next((s for s in found.short if s != UNSURE), "")
    told += f": {why}" * bool(why)
    if found.taken_up:
        told = f"a real gap, and {TAKEN_UP}: measure them, or state larger sds"
    key, sds = next(iter(found.moved.items()), ("", 0.0))
    if found.status == "no_gap" and abs(sds) >= DOUBTFUL:
        told += f", if {key} is {off_by(sds)}: that is then what is wrong"
        told += in_its_place(found.found.ranking, found.vehicle.known, key, sds)
    if found.status == "no_gap" and False in energies:
        told = told.replace("no gap", "no cause: no gap row by row")
        closed = key and closes(found.proof.before, found.proof.after)
        told += f"; {takes_it_up(key, sds) if closed else RARE}"
    elif found.status != "no_gap" and all(energies):
        told += "; the course of the signals shows it, their energy alone would not"
    least = min((a.probability for a in found.asserted), default=1.0)
    if least < SURE:
        sure = "not for sure" if least > EVEN else "as likely as not"
        sure = "less likely than not" if least < EVEN else sure
        told += f"; {sure}, at {probable(least)}"
    return told


def _bars(found: Diagnosis, room: int) -> tuple[str, str] | None:
    """Return the range of the gap of the power, and a line of bars over time."""
    gap = found.gap
    power = logged_power(gap.measured)
    if power is None or "battery_power_w" not in gap.simulated or room < LEAST_BARS:
        return None
    e = power - gap.simulated["battery_power_w"]
    if not np.isfinite(e).any() or len(e) < room:
        return None
    e = np.round(e, 6)
    e = moving_mean(e, max(len(e) // room, 1))[:: max(len(e) // (8 * room), 1)]
    return (
        f"{figures(float(e.min()), 2)} to {figures(float(e.max()), 2)} W:",
        sparkline(e.tolist(), room),
    )


def _cause(a: Asserted, logs: int) -> str:
    sure, first = probable(a.probability), a.cause.effect
    mean = "mean over the way" if a.cause.along_way else "mean"
    if not a.cause.tied:
        return f"{first}, probability {sure}: {_figures(a.figures, mean)}"
    any_of = " or ".join((first, *a.cause.tied))
    each = [(first, a.figures), *a.instead.items()]
    told = [f"if {effect}: {_figures(own, mean)}" for effect, own in each]
    return (
        f"{any_of}: {these(logs)} cannot tell them apart, probability {sure} that one "
        f"of them acts; {'; '.join(told)}"
    )


def _figures(told: Mapping[str, Estimate], mean: str) -> str:
    """Return the figures of an effect, each with its interval."""
    return ", ".join(
        f"{k} {_ends(x, mean)}{figures(x.value, 4)} ({figures(x.low, 4)} to "
        + f"{figures(x.high, 4)})"
        + ", at its bound" * is_at_bound(x.document())
        + (f", stated {figures(x.stated, 4)}" if x.stated is not None else "")
        for k, x in told.items()
    )


def _each(found: Diagnosis, a: Asserted) -> Iterator[str]:
    """Yield a line for each figure that has a mean of its own in each log."""
    for name, x in a.figures.items():
        if not x.each:
            continue
        told = [
            f"{short(gap.log)} {figures(e.value, 4)} ({figures(e.low, 4)} to "
            f"{figures(e.high, 4)})"
            for gap, e in zip(found.gaps, x.each, strict=True)
        ]
        rest = len(told) - SHOWN
        more = f", and {counted(rest, 'more log')}" * (rest > 0)
        yield f"mean {name} by log: {', '.join(told[:SHOWN])}{more}"


def _steps(found: Diagnosis, a: Asserted) -> Iterator[str]:
    """Yield when what varies goes from low to high, or back, if it seldom does."""
    profile = a.cause.profiles.get(found.shown)
    if profile is None or not a.cause.over_time:
        return
    at = profile.half_way
    if 0 < len(at) <= STEPS:
        first = "low" if profile.value[0] < profile.at(at[-1:])[0] else "high"
        told = listed([figures(round(x, 1), 12) for x in at.tolist()])
        yield f"{first} at first; half-way to the other end at {told} s"


def _ends(x: Estimate, mean: str) -> str:
    """Return between what a figure varies, if it does."""
    if x.least is None or x.most is None or x.least == x.most:
        return ""
    ends = f"{figures(x.least, 3)} to {figures(x.most, 3)}"
    return f"varies over the drive, {ends} (--profiles), {mean} "


def _rivals(found: Diagnosis) -> Iterator[tuple[str, str]]:
    taken = {a.cause.effect for a in found.asserted}
    tied = {t for a in found.asserted for t in a.cause.tied}
    rows = [r for r in found.document()["ranking"] if r["effect"] not in taken | tied]
    told = [
        f"{OTHERS.get(r['effect'], r['effect'])} {probable(r['probability'])}"
        for r in rows[:RIVALS]
        if r["probability"] > 0
    ]
    if told and found.asserted:
        yield "RIVALS", ", ".join(told)


def _proof(found: Diagnosis) -> Iterator[tuple[str, str]]:
    proof = found.proof
    s, before, after = proof.shrink, proof.before, proof.after
    energy = ""
    if before is not None and after is not None:
        how = ", by the torque measured," if proof.by_torque else ""
        energy = (
            f"; energy gap there{how} {rounded(before, 1)} % before, "
            f"{rounded(after, 2)} % after" + ": it grew" * grew(before, after)
        )
        more = outweighing(found)
        energy += f", more of it by {more} than by the cause" * bool(more)
    gone = (
        f"{percent(s.explained)} of what is beyond noise is gone ({percent(s.low)} to "
        f"{percent(s.high)})"
    )
    if s.low < 0:
        gone += ": hardly anything was, so that is not sure"
    if not s.tells:
        gone = "too little is beyond noise, row by row, to tell what of it is gone"
    if found.courses_fitted:
        energy += "; the course of what varies was fitted there as well"
    yield "PROOF", f"on {_held_out(found)} {gone}{energy}"


def outweighing(found: Diagnosis) -> str:
    """Return what closes an energy gap more than the causes do, if anything.

    Such causes show in the course of the signals alone.
    """
    prices = found.prices
    if prices is None or not found.asserted:
        return ""
    causes = abs(sum(prices.causes.values()))
    small = SMALL * abs(found.gap.energy.measured_wh or 0.0)
    worth = {SHIFTS: abs(prices.figures_wh), METERS: abs(prices.meters_wh)}
    most = max(worth, key=lambda what: worth[what])
    return most if worth[most] > max(causes, small) else ""


def _held_out(found: Diagnosis) -> str:
    """Return on what causes were proven."""
    if not found.kept_back:
        return "rows that no fit saw"
    more = len(found.kept_back) - SHOWN
    names = ", ".join(map(short, found.kept_back[:SHOWN]))
    return names + f" and {counted(more, 'more log')}" * (more > 0)


def _ledger(found: Diagnosis) -> Iterator[tuple[str, str]]:
    prices = found.prices
    if prices is None:
        return
    small = SMALL * abs(found.gap.energy.measured_wh or 0.0)
    others = (prices.figures_wh, prices.meters_wh)
    if not found.asserted and max(map(abs, others)) <= small:
        return
    how = "by the motion alone: " * found.proof.by_torque
    ties = {a.cause.effect for a in found.asserted if a.cause.tied}
    named = {c: c + OR_TIE * (c in ties) for c in prices.causes}
    steps = [f"{named[c]} {_wh(wh)}" for c, wh in prices.causes.items()]
    if abs(prices.drive_wh) > small:
        steps.insert(0, f"{OTHER_DRIVE} {_wh(prices.drive_wh)}")
    steps.append(f"{SHIFTS} {_wh(prices.figures_wh)}")
    if abs(prices.meters_wh) > small:
        steps.append(f"{METERS} {_wh(prices.meters_wh)}")
    steps.append(f"unexplained {_wh(prices.unexplained_wh)}")
    yield "ENERGY", how + ", ".join(steps)


def _wh(energy: float | None) -> str:
    return "" if energy is None else f"{'+' * (energy >= 0)}{figures(energy)} Wh"
