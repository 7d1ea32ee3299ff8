"""The verdict of a diagnosis in one sentence, with its figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rcc_sim.diagnose.fitting.pulls import is_of
from rcc_sim.diagnose.judge.energies import TELLS_NOTHING, stays_off
from rcc_sim.physics.effect import Effect
from rcc_sim.report.text import figures, listed, percent, probable, signed
from rcc_sim.units import SUFFIXES, unit_of

STATUS = {
    "no_gap": "no gap",
    "explained": "explained",
    "partly_explained": "partly explained",
    "unexplained": "unexplained",
}

DOUBTFUL = 3.0
"""Standard deviations by which a stated figure is off, from which on it is doubtful."""

MANY, OTHER = 4, "was it this vehicle that drove?"
"""Causes from which on another vehicle is likelier than so many effects, and what is
asked then. Of 1150 drives of the blind plant one has three, none more."""

MOSTLY = 0.5
"""Share of what is left of a channel from which on it is doubtful that it is noise, if
its own past foresees it: of 24 commanded drives of the blind plant without a cause none
has more than 0.34 in any channel but the speed."""

TAKEN_UP = "no effect is needed: stated figures take it up as moved"
"""What a real gap is where the mended file has no cause."""

VAGUE = 0.1
"""What the share that is explained may come short of itself by before that is told."""

JUDGED = 4
"""Channels, or what stands for the rest of them, that are told at most."""


def verdict_of(diagnosis: Mapping[str, Any]) -> str:
    """Return what a diagnosis (`DESIGN` §5's object, whole or ``where`` alone) says.

    An empty text if it says nothing.
    """
    where = diagnosis.get("where") or {}
    energy = where.get("energy") or {}
    status = diagnosis.get("status")
    if status is None:
        parts = [_gap(energy), _place(where)]
    elif status == "no_gap":
        told = _gap(energy)
        names = [str(c["channel"]) for c in where.get("channels") or []]
        place = judged(names, energy.get("measured_wh"))
        both = "the noise and the vehicle file's stated doubt"
        if energy.get("within") is False:
            key, sds = next(iter((diagnosis.get("moved") or {}).items()), ("", 0.0))
            taken = "nothing that was asked takes it up; one more drive tells"
            there = diagnosis.get("shrink") or {}
            before = there.get("energy_gap_percent_before")
            if closes(before, there.get("energy_gap_percent_after")):
                taken = takes_it_up(key, sds)
            parts = [f"no gap{place} beyond {both}, row by row", told, taken]
        else:
            doubt = "doubt" if told else both
            parts = [f"no gap{place} beyond {doubt}", told or "no energy was judged"]
        parts.append(hangs_together(diagnosis))
    elif status == "unexplained" and diagnosis.get("taken_up"):
        parts = [f"a real gap, and {TAKEN_UP}", _mended(diagnosis)]
    elif status == "unexplained":
        parts = [
            _unexplained(
                diagnosis.get("candidates") or [], within=energy.get("within")
            ),
            _unless(diagnosis.get("findings") or []),
            _gap(energy, plain=not energy.get("within")),
        ]
    else:
        parts = [_because(diagnosis), _mended(diagnosis)]
        if status == "partly_explained":
            parts += diagnosis.get("comes_short") or []
    odd = [str(x["log"]) for x in diagnosis.get("by_log") or [] if x["disagrees"]]
    if odd:
        go = "does" if len(odd) == 1 else "do"
        parts.append(f"{listed(odd)} {go} not go with the other logs")
    together = diagnosis.get("moved_together") or 0.0
    left = status == "unexplained" and not diagnosis.get("taken_up")
    doubt = doubt_of(diagnosis.get("moved") or {}, together, named=True, left=left)
    parts.append(doubt)
    if OTHER not in doubt:
        found = diagnosis.get("causes") or []
        parts.append(too_many({c["effect"]: c.get("parameters") or {} for c in found}))
    sentence = "; ".join(part for part in parts if part)
    end = "" if sentence.endswith("?") else "."
    return sentence[:1].upper() + sentence[1:] + end if sentence else ""


def in_its_place(
    gains: Mapping[str, float], known: Mapping[str, Effect], key: str, sds: float
) -> str:
    """Return what may act where a figure is so far off instead, if anything may.

    That is the effect that gains most, if it is half of what the figure costs: with d
    standard deviations, d²/2 nats.
    """
    others = {e: gain for e, gain in gains.items() if not is_of(known[e], key)}
    best = max(others, key=others.__getitem__, default="")
    enough = others.get(best, 0.0) >= 0.25 * sds**2
    return f", or {best} acts in its place" if enough else ""


def takes_it_up(key: str, sds: float) -> str:
    """Return what is said of an energy gap that stated figures close, one the most.

    They do so within what is stated of them all: a second drive says the same, and what
    their sds allow is no cause. Of one that is too many ``sds`` off a smaller one would
    make it so; that it may be too small is said beside it.
    """
    which = f"as moved, {key} the most: measure it" if key else "together: measure them"
    smaller = ", or state a smaller sd" * (abs(sds) < DOUBTFUL)
    return f"stated figures take the energy up {which}{smaller}"


def closes(before: float | None, after: float | None) -> bool:
    """Tell whether an energy gap [%] is gone where no fit saw, or none is known."""
    return (
        before is None or after is None or not stays_off(before, after, doubtless=True)
    )


def _unexplained(asked: Sequence[str], *, within: bool | None) -> str:
    real = "a real gap" + " in the course of the signals" * bool(within)
    return f"{real} that {unaccounted(asked)}"


def unaccounted(asked: Sequence[str]) -> str:
    """Return what does not account for a gap: the library, or what alone was asked.

    >>> unaccounted(["payload", "road_grade"])
    'payload or road grade does not account for, and nothing else was asked'
    """
    if not asked:
        return "no effect of the library accounts for"
    names = listed([name.replace("_", " ") for name in asked], "or")
    return f"{names} does not account for, and nothing else was asked"


def _unless(findings: Sequence[Mapping[str, Any]]) -> str:
    """Return which channel may be what is wrong, rather than the model."""
    names = [str(f["channel"]) for f in findings if f["kind"] == "may_wander"]
    return f"unless {names[0]} wanders, which nothing in the log tells" if names else ""


def _gap(energy: Mapping[str, Any], *, plain: bool = False) -> str:
    measured, simulated = energy.get("measured_wh"), energy.get("simulated_wh")
    if measured is None or simulated is None:
        return ""
    gap = energy.get("gap_percent") or 0.0
    place = " at the shaft" if energy.get("at") == "shaft" else ""
    text = (
        f"of the energy that the log took{place}, the model {_missed(gap, 3)} "
        f"({figures(measured)} Wh against {figures(simulated)} Wh)"
    )
    if plain or energy.get("within") is None:
        return text
    how = "within" if energy["within"] else "more than"
    return f"{text}, {how} what noise and the vehicle file's stated doubt allow"


def doubt_of(
    moved: Mapping[str, float],
    together: float = 0.0,
    *,
    named: bool = False,
    left: bool = False,
) -> str:
    """Return what it means that stated figures moved by so many sds, if it is much.

    ``together`` is how far off one would be that is as unlikely as all of them. Where a
    gap is ``left`` that nothing explains they may stand in for that.

    >>> doubt_of({"body.mass_kg": -4.1}, named=True)
    'body.mass_kg is 4.1 sds off what is stated: measure it again, or state a larger sd'
    >>> doubt_of({"body.mass_kg": -4.1}, left=True)
    'may stand in for what nothing explains: measure it again'
    >>> doubt_of({"body.mass_kg": -29.0})
    'was it this vehicle that drove?'
    >>> doubt_of({"body.mass_kg": -9.5, "tyres.radius_m": 8.0}, 12.1)
    'together as unlikely as one figure 12 sds off: was it this vehicle that drove?'
    """
    from rcc_sim.diagnose.causes.cause import ANOTHER_VEHICLE
    from rcc_sim.diagnose.judge.verdict import TOLERATED

    key, sds = next(iter(moved.items()), ("", 0.0))
    far = max(abs(sds), together)
    alone = abs(sds) > ANOTHER_VEHICLE or together <= TOLERATED
    if (abs(sds) if alone else far) < DOUBTFUL:
        return ""
    what = f"{key} is {off_by(sds)}: " if named else ""
    if not alone:
        what = "the stated figures moved " if named else ""
        what += f"together as unlikely as one figure {figures(far, 2)} sds off: "
    again = "may stand in for what nothing explains: " * left + "measure it again"
    again += ", or state a larger sd" * (not left)
    return what + (OTHER if far > ANOTHER_VEHICLE else again)


def off_by(sds: float) -> str:
    """Return by how much a figure is off what a file states."""
    return f"{figures(abs(sds), 2)} sds off what is stated"


def hangs_together(diagnosis: Mapping[str, Any]) -> str:
    """Return what it means that most of what is left of a channel is foreseen.

    A vehicle that is driven by its measured motion shows the road in all that it takes,
    and a speed sums up what roughness there was: of these it means nothing.

    >>> hangs_together({"mode": "commanded", "foreseen": {"speed_mps": 0.8}})
    ''
    """
    if diagnosis.get("mode") != "commanded":
        return ""
    foreseen = dict(diagnosis.get("foreseen") or {})
    foreseen.pop("speed_mps", None)
    channel = max(foreseen, key=lambda c: foreseen[c], default="")
    if not channel or foreseen[channel] < MOSTLY:
        return ""
    return (
        f"{percent(foreseen[channel])} of what is left of {channel} is foreseen by "
        "what was left just before, as a rough road or a sensor that filters would "
        "have it, or something missing that comes and goes: --repeats of the drive tell"
    )


def too_many(causes: Mapping[str, Mapping[str, Any]]) -> str:
    """Return what so many causes at once ask, by their figures; nothing of few.

    One less will do where a figure is at an end of what it may be.

    >>> payload = {"mass_kg": {"value": -794.0, "low": -794.0, "high": -511.0}}
    >>> too_many({"payload": payload, "road_load": {}, "current_sensor_scale": {}})
    '3 causes at once, payload at a bound: was it this vehicle that drove?'
    >>> too_many({"payload": payload})
    ''
    """
    ends = [
        name.replace("_", " ")
        for name, figures_of in causes.items()
        if any(map(is_at_bound, figures_of.values()))
    ]
    if len(causes) < MANY - bool(ends):
        return ""
    where = f", {listed(ends)} at a bound" if ends else ""
    return f"{len(causes)} causes at once{where}: {OTHER}"


def is_at_bound(figure: Any) -> bool:
    """Tell whether a figure is at an end of its interval, which its bounds then cut."""
    return isinstance(figure, Mapping) and figure.get("value") in (
        figure.get("low"),
        figure.get("high"),
    )


def judged(names: Sequence[str], energy_wh: float | None) -> str:
    """Return in which channels a gap was sought, where no energy was measured.

    >>> judged(["yaw_rate_radps"], None)
    ' in yaw_rate_radps'
    """
    if not names or energy_wh is not None:
        return ""
    if len(names) > JUDGED:
        names = [*names[: JUDGED - 1], f"{len(names) - JUDGED + 1} more"]
    return f" in {listed(names)}"


def _place(where: Mapping[str, Any]) -> str:
    told = []
    for kind, key, words in (
        ("regimes", "regime", "{wh} Wh of it in {name}"),
        ("stages", "stage", "{wh} Wh of it in the {name} stage"),
    ):
        rows = [r for r in where.get(kind) or [] if r.get("gap_wh") is not None]
        if rows:
            most = max(rows, key=lambda r: abs(r["gap_wh"]))
            name = str(most[key]).replace("_", " ")
            told.append(words.format(wh=signed(most["gap_wh"]), name=name))
    return ", ".join(told)


def _because(diagnosis: Mapping[str, Any]) -> str:
    causes = diagnosis.get("causes") or []
    shrink = diagnosis.get("shrink") or {}
    logs = len(diagnosis.get("logs") or [])
    names = [_cause(cause, logs) for cause in causes]
    text = f"{listed(names)} {'explain' if len(names) > 1 else 'explains'} "
    explained = shrink.get("explained")
    if explained is None:
        return text + "it"
    low, high = (shrink.get(end, explained) for end in ("low", "high"))
    if high - low >= TELLS_NOTHING:
        return text + "it"
    text += f"{percent(explained)} of what is beyond noise"
    if low < explained - VAGUE:
        text += f" ({percent(low)} at least)" if low > 0 else ", or nothing"
    if shrink.get("held_out"):
        text += ", on data that no fit saw"
    return text


def _mended(diagnosis: Mapping[str, Any]) -> str:
    """Return the energy gap, and what the mended vehicle leaves of it.

    It has the causes, and the stated figures as the log moved them.
    """
    energy = diagnosis.get("where", {}).get("energy") or {}
    shrink = diagnosis.get("shrink") or {}
    gap = shrink.get("energy_gap_percent_before", energy.get("gap_percent"))
    after = shrink.get("energy_gap_percent_after")
    if gap is None:
        return ""
    there = "taken there" if shrink.get("held_out") else "that the log took"
    how = " by the torque measured," if shrink.get("energy_by_measured_torque") else ""
    text = f"of the energy {there},{how} the model {_missed(gap, 3)}"
    if after is not None:
        text += f", and {_missed(after, 2)} once it is mended"
    return text


def _missed(gap: float, digits: int) -> str:
    what = "misses" if gap >= 0 else "adds"
    return f"{what} {figures(abs(gap), digits)} %"


def these(logs: int) -> str:
    """Return what a diagnosis calls the logs that it was made from."""
    return "these logs" if logs > 1 else "this log"


def _cause(cause: Mapping[str, Any], logs: int) -> str:
    text = str(cause.get("effect", "?")).replace("_", " ")
    others = cause.get("indistinguishable_from") or []
    if others:
        text = " or ".join([text, *(str(o).replace("_", " ") for o in others)])
    told = []
    parameters = cause.get("parameters") or {}
    if len(parameters) == 1 and not others:
        told += [strength(*pair) for pair in parameters.items()]
    if cause.get("probability") is not None:
        told.append(f"probability {probable(cause['probability'])}")
    if others:
        told.append(f"{these(logs)} cannot tell them apart")
    return f"{text} ({'; '.join(told)})" if told else text


def strength(name: str, figure: Any) -> str:
    """Return a figure of an effect in words.

    >>> strength("mass_kg", {"value": 1.2546})
    'mass 1.25 kg'
    >>> strength("power_w", {"value": 1851.0, "stated": 350.0})
    'power 1851 W, stated 350'
    >>> strength("slope", {"value": 0.0001, "least": -0.026, "most": 0.031})
    'slope −0.026 to 0.031, mean 0.0001'
    """
    of = figure if isinstance(figure, Mapping) else {"value": figure}
    unit = "" if unit_of(name) == "1" else f" {unit_of(name)}"
    ends = (e for e in SUFFIXES if name.endswith("_" + e))
    plain = name.removesuffix("_" + next(ends, "")).replace("_", " ")
    told = figures(of.get("value"))
    if "least" in of:
        span = f"{figures(of['least'])} to {figures(of['most'])}"
        told = f"{plain} {span}{unit}, mean {told}"
    else:
        told = f"{plain} {told}{unit}"
    stated = of.get("stated")
    return told if stated is None else f"{told}, stated {figures(stated)}"
