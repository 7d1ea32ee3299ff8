"""How far a diagnosis deserves trust: sealed labels opened, answers counted."""

from __future__ import annotations

import operator
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import isfinite, nan
from pathlib import Path
from typing import Any

from rcc_sim.blind.answers import SAME, Row, answer, any_alike, named_above
from rcc_sim.blind.measures import Share, calibration, share, spread
from rcc_sim.blind.run import read_results
from rcc_sim.blind.seal import opened
from rcc_sim.errors import InputError

SURE = 0.5  # 1; a cause named with more probability than this is a claim
GONE = 1.5  # percent; an energy gap below this counts as gone
THERE = 3.0  # percent; an energy gap above this counts as one to shrink
COMPARE: dict[str, Callable[[float, float], bool]] = {
    ">=": operator.ge, "<=": operator.le, ">": operator.gt, "<": operator.lt,
}  # fmt: skip


def score(out: Path, labels: Path) -> dict[str, Any]:
    """Open the labels and score the results of a folder of cases.

    Raises
    ------
    CheckFailed
        If the labels are not those that were sealed.
    InputError
        If no case was run.
    """
    truth = opened(out, labels)["cases"]
    results = read_results(out)
    if not results:
        raise InputError(
            f"{out}: no results", f"`rccsim blind run {out}` diagnoses the cases"
        )
    stray = sorted(results.keys() - truth.keys())
    if stray:
        raise InputError(f"{out}: results of a case without a label: {stray[0]}")
    rows = [answer(n, truth[n], results[n], out) for n in sorted(results)]
    families = sorted({r["family"] for r in rows})
    return {
        "schema": "rccsim.blind_score/1",
        "cases": len(truth),
        "run": len(rows),
        "same": [sorted(group) for group in SAME],
        **summary(rows),
        "by_family": {
            f: summary([r for r in rows if r["family"] == f])["shares"]
            for f in families
        },
        "by_effect": by_effect(rows),
        "confusion": confusion(rows),
        "rows": rows,
    }


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """Return every share, spread and calibration of some rows."""
    kind = {k: [r for r in rows if r["kind"] == k] for k in KINDS}
    acting = kind["single"] + kind["pair"]
    claims = [
        (p, any_alike(n, r["true"]))
        for r in rows
        for n, p in zip(r.get("named", []), r.get("probabilities", []), strict=True)
    ]
    covered = [
        f["covered"]
        for r in acting
        for f in r.get("parameters", [])
        if f["covered"] is not None
    ]
    energy = [r["fresh_energy_percent"] for r in acting if "fresh_energy_percent" in r]
    shares = {
        "ran": share([r["ran"] for r in rows]),
        "single_first": share([r.get("first", False) for r in kind["single"]]),
        "single_in_three": share([r.get("in_three", False) for r in kind["single"]]),
        "single_in_tie": share([_in_tie(r) for r in kind["single"]]),
        "single_exact": share([_exact(r, 1) for r in kind["single"]]),
        "pair_exact": share([_exact(r, 2) for r in kind["pair"]]),
        "pair_one": share(
            [r.get("hits", 0) >= 1 and r["extra"] == 0 for r in kind["pair"]]
        ),
        "null_quiet": share(
            [r.get("status") == "no_gap" and not r["named"] for r in kind["null"]]
        ),
        "null_false_alarm": share([bool(r.get("named")) for r in kind["null"]]),
        "unknown_admitted": share(
            [
                r.get("status") in ("unexplained", "partly_explained")
                and not named_above(r, SURE)
                for r in kind["unknown"]
            ]
        ),
        "unknown_falsely_named": share([named_above(r, SURE) for r in kind["unknown"]]),
        "interval_coverage": share(covered),
        "fresh_energy_shrank": share(shrank(energy)),
        "fresh_energy_by_chance": share(
            shrank(
                (r["fresh_energy_percent"][0], r["fresh_chance_percent"])
                for r in acting
                if {"fresh_energy_percent", "fresh_chance_percent"} <= r.keys()
            )
        ),
    }
    return {
        "shares": {k: s.document() for k, s in shares.items()},
        "spreads": spreads(rows, acting, energy),
        "calibration": calibration([p for p, _ in claims], [ok for _, ok in claims]),
        "windows": _means([r["where"] for r in rows if r.get("where")]),
        "profiles": {
            name: _means(
                [r["profiles"][name] for r in rows if name in r.get("profiles", {})]
            )
            for name in sorted({n for r in rows for n in r.get("profiles", {})})
        },
    }  # fmt: skip


KINDS = ("single", "pair", "null", "unknown")


def shrank(energy: Iterable[Sequence[float]]) -> list[bool]:
    """Tell of each gap that was there before whether it is gone, or a third. [%]"""
    return [b < max(GONE, a / 3) for a, b in energy if a > THERE]


def _in_tie(row: Row) -> bool:
    """Tell whether what acted is the first cause, or tied with it by the answer."""
    if not row.get("named"):
        return False
    told = [row["named"][0], *row["ties"][0]]
    return any(any_alike(t, told) for t in row["true"])


def _exact(row: Row, count: int) -> bool:
    return bool(row.get("hits") == count and row.get("extra") == 0)


def spreads(
    rows: Sequence[Row], acting: Sequence[Row], energy: Sequence[Sequence[float]]
) -> dict[str, dict[str, float]]:
    """Return median and 90th percentile of errors, gaps left and times."""

    def errors(key: str) -> list[float]:
        return [f["error"] for r in acting for f in r.get(key, [])]

    explained = [r["fresh_explained"] for r in acting if "fresh_explained" in r]
    return {
        "parameter_error": spread(errors("parameters")),
        "parameter_error_over_file": spread(errors("over_file")),
        "fresh_energy_before_percent": spread([e[0] for e in energy]),
        "fresh_energy_after_percent": spread([e[1] for e in energy]),
        "fresh_energy_by_chance_percent": spread(
            [r["fresh_chance_percent"] for r in acting if "fresh_chance_percent" in r]
        ),
        "fresh_explained": spread(explained),
        "tie_size": spread([1.0 + len(t) for r in rows for t in r.get("ties", [])]),
        "seconds": spread([r["seconds"] for r in rows if r["seconds"] is not None]),
    }


def _means(rows: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the median of each measure over the cases that have it."""
    found: dict[str, float] = {"n": len(rows)}
    for key in sorted({k for r in rows for k in r}):
        found[key] = spread([r[key] for r in rows if isfinite(r.get(key, nan))])[
            "median"
        ]
    return found


def confusion(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """Return how often each truth got each answer: effect, or status if none is named.

    A truth is the effect of a single case, ``null``, or what is in no library.
    """
    table: dict[str, Counter[str]] = {}
    for row in rows:
        if row["kind"] == "pair" or not row["ran"]:
            continue
        truth = "null" if row["kind"] == "null" else row["acting"][0]
        given = row["named"][0] if row["named"] else str(row["status"])
        table.setdefault(truth, Counter())[given] += 1
    return {truth: dict(table[truth].most_common()) for truth in sorted(table)}


def by_effect(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """Return, for each effect that acted, how often it was among those named."""
    table: dict[str, dict[str, int]] = {}
    for row in rows:
        for effect in row["true"]:
            cell = table.setdefault(effect, {"acted": 0, "named": 0})
            cell["acted"] += 1
            cell["named"] += any_alike(effect, row.get("named", []))
    return dict(sorted(table.items()))


def figures(document: Mapping[str, Any]) -> dict[str, float]:
    """Return every single figure of a score by the key that ``--require`` knows."""
    flat = {key: s["value"] for key, s in document["shares"].items()}
    for key, s in document["spreads"].items():
        flat |= {f"{key}_median": s["median"], f"{key}_p90": s["p90"]}
    flat |= {f"calibration_{k}": document["calibration"][k] for k in ("ece", "brier")}
    flat |= {f"windows_{k}": v for k, v in document["windows"].items() if k != "n"}
    for name, profile in document["profiles"].items():
        flat |= {f"{name}.{k}": v for k, v in profile.items() if k != "n"}
    return flat


def failures(document: Mapping[str, Any], bars: Sequence[str]) -> list[str]:
    """Return the bars that are not reached, in words.

    Raises
    ------
    InputError
        If a bar is not KEY>=VALUE (or <=, >, <), or there is no such key.
    """
    flat = figures(document)
    missed = []
    for bar in bars:
        parts = re.fullmatch(r"\s*([\w.]+)\s*(>=|<=|>|<)\s*(\S+)\s*", bar)
        if parts is None:
            raise InputError(f"--require: should be KEY>=VALUE or KEY<=VALUE: {bar!r}")
        key, sign, text = parts.groups()
        if key not in flat:
            raise InputError(f"--require: no such figure: {key!r}", ", ".join(flat))
        try:
            limit = float(text)
        except ValueError:
            raise InputError(f"--require: not a number: {text!r}") from None
        if not COMPARE[sign](flat[key], limit):
            found = f"{flat[key]:.4g}" if isfinite(flat[key]) else "no such case here"
            missed.append(f"{key} should be {sign} {limit:g}: {found}")
    return missed


def table(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the score as rows for a person: figure, value, interval, of how many."""
    rows: list[dict[str, Any]] = []
    for key, s in document["shares"].items():
        rows.append(_line(key, s["value"], s["low"], s["high"], s["of"]))
    for key, s in document["spreads"].items():
        rows.append(_line(f"{key}_median", s["median"], None, None, s["n"]))
        rows.append(_line(f"{key}_p90", s["p90"], None, None, s["n"]))
    n = document["calibration"]["n"]
    rows += [
        _line(f"calibration_{k}", document["calibration"][k], None, None, n)
        for k in ("ece", "brier")
    ]
    windows = document["windows"]
    rows += [
        _line(f"windows_{k}", v, None, None, windows["n"])
        for k, v in windows.items()
        if k != "n"
    ]
    for name, profile in document["profiles"].items():
        rows += [
            _line(f"{name}.{k}", v, None, None, profile["n"])
            for k, v in profile.items()
            if k != "n"
        ]
    for b in document["calibration"]["bins"]:
        right = Share(round(b["right"] * b["n"]), b["n"])
        key = f"right where said {b['from']:g} to {b['to']:g}"
        rows.append(_line(key, right.value, *right.interval, b["n"]))
    for effect, cell in document["by_effect"].items():
        named = Share(cell["named"], cell["acted"])
        rows.append(_line(f"{effect} named", named.value, *named.interval, named.of))
    for truth, answers in document["confusion"].items():
        of = sum(answers.values())
        rows += [
            _line(f"{truth} -> {given}", count, None, None, of)
            for given, count in answers.items()
        ]
    return rows


def _line(
    key: str, value: float, low: float | None, high: float | None, of: float
) -> dict[str, Any]:
    return {
        "figure": key,
        "value": value if isfinite(value) else None,
        "low_95": low,
        "high_95": high,
        "of": int(of),
    }
