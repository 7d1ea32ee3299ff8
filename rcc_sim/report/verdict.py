"""The verdict of a diagnosis in one sentence, with its figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rcc_sim.report.text import figures, percent

STATUS = {
    "no_gap": "no gap",
    "explained": "explained",
    "partly_explained": "partly explained",
    "unexplained": "unexplained",
}


def verdict_of(diagnosis: Mapping[str, Any]) -> str:
    """Return what a diagnosis (`DESIGN` §5's object, whole or ``where`` alone) says.

    An empty text if it says nothing.
    """
    where = diagnosis.get("where") or {}
    parts = [_gap(where.get("energy") or {})]
    status = diagnosis.get("status")
    if status is None:
        parts.append(_place(where))
    elif status == "no_gap":
        parts.append("nothing beyond the noise and the vehicle file's stated doubt")
    elif status == "unexplained":
        parts.append("no effect of the library accounts for it")
    else:
        parts.append(_because(diagnosis))
    sentence = "; ".join(part for part in parts if part)
    return sentence[:1].upper() + sentence[1:] + "." if sentence else ""


def _gap(energy: Mapping[str, Any]) -> str:
    measured, simulated = energy.get("measured_wh"), energy.get("simulated_wh")
    if measured is None or simulated is None:
        return ""
    gap = energy.get("gap_percent")
    if gap is None:
        gap = 100 * (measured - simulated) / measured if measured else 0.0
    more = "more" if measured >= simulated else "less"
    place = " at the shaft" if energy.get("at") == "shaft" else ""
    text = (
        f"the log took {figures(abs(gap))} % {more} energy{place} than the model says "
        f"({figures(measured)} Wh against {figures(simulated)} Wh)"
    )
    if energy.get("within") is None:
        return text
    how = "within" if energy["within"] else "more than"
    return f"{text}, {how} what noise and the vehicle file's stated doubt allow"


def _place(where: Mapping[str, Any]) -> str:
    told = []
    for kind, key, words in (
        ("regimes", "regime", "{share} of it in {name}"),
        ("stages", "stage", "{share} of it in the {name} stage"),
    ):
        rows = [r for r in where.get(kind) or [] if r.get("share") is not None]
        if rows:
            most = max(rows, key=lambda r: abs(r["share"]))
            name = str(most[key]).replace("_", " ")
            told.append(words.format(share=percent(most["share"]), name=name))
    return ", ".join(told)


def _because(diagnosis: Mapping[str, Any]) -> str:
    causes = diagnosis.get("causes") or []
    shrink = diagnosis.get("shrink") or {}
    names = [_cause(cause) for cause in causes]
    some = " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
    text = f"{some} {'explain' if len(names) > 1 else 'explains'} "
    explained = shrink.get("explained")
    if explained is None:
        return text + "it"
    text += percent(explained)
    if shrink.get("low") is not None and shrink.get("high") is not None:
        text += f" ({percent(shrink['low'])} to {percent(shrink['high'])})"
    text += " of what is beyond noise"
    if shrink.get("held_out"):
        text += ", on data that no fit saw"
    before = shrink.get("energy_gap_percent_before")
    after = shrink.get("energy_gap_percent_after")
    if before is not None and after is not None:
        text += (
            f", and the energy gap falls from {figures(before)} % "
            f"to {figures(after, 2)} %"
        )
    if diagnosis.get("status") == "partly_explained":
        text += "; structure remains that it does not explain"
    return text


def _cause(cause: Mapping[str, Any]) -> str:
    text = str(cause.get("effect", "?")).replace("_", " ")
    told = []
    if cause.get("probability") is not None:
        told.append(f"probability {percent(cause['probability'])}")
    others = cause.get("indistinguishable_from") or []
    if others:
        names = " or ".join(str(o).replace("_", " ") for o in others)
        told.append(f"this log cannot tell it from {names}")
    return f"{text} ({'; '.join(told)})" if told else text
