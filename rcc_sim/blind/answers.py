"""One diagnosis held against its label."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from rcc_sim.blind.drives import TIMING
from rcc_sim.blind.measures import agreement, overlap
from rcc_sim.trace import integral_of

SAME = (
    {"rolling_resistance", "drivetrain_friction", "road_grade"},
    {"drivetrain_damping", "iron_loss"},
    {"aerodynamic_drag", "headwind"},
)
"""What no log of this kind can tell apart: naming any member counts as right; a pair
never holds two of one."""
NOISY = 1.2  # 1; a channel counts whose square error is this much above its noise
MOVING = 0.3  # m/s; slopes are compared where the vehicle is faster

Row = dict[str, Any]


def alike(a: str, b: str) -> bool:
    """Tell whether two effects are the same, or one such log cannot tell them apart."""
    return a == b or any(a in group and b in group for group in SAME)


def any_alike(name: str, others: Iterable[str]) -> bool:
    """Tell whether an effect is alike to one of some others."""
    return any(alike(name, other) for other in others)


def answer(
    name: str, label: Mapping[str, Any], result: Mapping[str, Any], out: Path
) -> Row:
    """Return what one diagnosis got right and wrong, as one row."""
    row: Row = {
        "case": name,
        "kind": label["kind"],
        "family": label["family"],
        "true": list(label["effects"]),
        "acting": label["effects"] or sorted(label["magnitudes"]),
        "seconds": result.get("seconds"),
        "error": result.get("error", ""),
    }
    diagnosis = result.get("diagnosis")
    row["ran"] = bool(diagnosis)
    if not diagnosis:
        return row
    causes = diagnosis.get("causes", [])
    named = [c["effect"] for c in causes]
    ranking = [r["effect"] for r in diagnosis.get("ranking", [])]
    ranked = list(dict.fromkeys([*named, *ranking]))
    true = row["true"]
    row |= {
        "status": diagnosis.get("status"),
        "named": named,
        "probabilities": [float(c.get("probability", 0.0)) for c in causes],
        "hits": sum(any_alike(t, named) for t in true),
        "extra": sum(not any_alike(n, true) for n in named),
        "first": bool(named and any_alike(named[0], true)),
        "ties": [list(c.get("indistinguishable_from", [])) for c in causes],
        "in_three": any(any_alike(n, true) for n in ranked[:3]),
        "claimed": diagnosis.get("shrink", {}).get("explained"),
    }
    row["parameters"] = _parameters(causes, label["magnitudes"])
    row["over_file"] = _parameters(causes, label.get("over_file", {}))
    if label["kind"] in ("single", "pair"):
        row |= _fresh(result.get("fresh", {}))
        if "gap_by_chance_percent" in label.get("fresh", {}):
            row["fresh_chance_percent"] = abs(label["fresh"]["gap_by_chance_percent"])
    if label["kind"] == "unknown":
        row["where"] = _windows(diagnosis, label)
    row["profiles"] = _profiles(name, label, out)
    return row


def _parameters(
    causes: Iterable[Mapping[str, Any]], magnitudes: Mapping[str, Any]
) -> list[Row]:
    """Return the error of each figure, as a share of its departure from neutral."""
    found = []
    for cause in causes:
        for key, true in magnitudes.get(cause["effect"], {}).items():
            got = cause.get("parameters", {}).get(key)
            if got is None:
                continue
            size = (
                abs(true - 1) if key == "gain" or key.endswith("scale") else abs(true)
            )
            if key == "efficiency":
                size = abs(true - 1)
            if not size:
                continue
            low, high = got.get("low"), got.get("high")
            inside = None if low is None or high is None else low <= true <= high
            found.append({
                "figure": f"{cause['effect']}.{key}",
                "error": abs(got["value"] - true) / size,
                "covered": inside,
            })  # fmt: skip
    return found


def _fresh(fresh: Mapping[str, Any]) -> Row:
    """Return how the gap on the fresh drive shrank: energy, and the best channel."""
    if not {"before", "after"} <= fresh.keys():
        return {}
    row: Row = {}
    energy = [
        fresh[k].get("energy", {}).get("gap_percent") for k in ("before", "after")
    ]
    if None not in energy:
        row["fresh_energy_percent"] = [abs(float(e)) for e in energy]
    channels = [
        {c["channel"]: c for c in fresh[k].get("channels", [])}
        for k in ("before", "after")
    ]
    explained = []
    for name, old in channels[0].items():
        noise = float(old.get("noise") or 0.0) ** 2
        before = float(old["rmse"]) ** 2
        if name in channels[1] and before > NOISY * noise:
            after = max(float(channels[1][name]["rmse"]) ** 2 - noise, 0.0)
            explained.append(1 - after / (before - noise))
    if explained:
        row["fresh_explained"] = max(explained)
    return row


def _windows(diagnosis: Mapping[str, Any], label: Mapping[str, Any]) -> Row | None:
    """Compare the windows of what stayed unexplained with where it acted."""
    windows = diagnosis.get("unexplained", {}).get("windows") or []
    windows = windows or diagnosis.get("where", {}).get("windows") or []
    spans = [(w["start_s"], w["end_s"]) for w in windows if "start_s" in w]
    lasts = TIMING[label["family"]].seconds
    return overlap(spans, label["windows"]["log"], lasts)


def _profiles(name: str, label: Mapping[str, Any], out: Path) -> dict[str, Any]:
    """Compare each estimated profile with the true one, row by row of its file."""
    path = out / "results" / f"{name}.profiles.csv"
    if not label.get("profiles") or not path.exists():
        return {}
    import pandas

    got = pandas.read_csv(path)
    found = {}
    for column, true in label["profiles"].items():
        if column not in got:
            continue
        time = got["time_s"].to_numpy()
        if "time_s" in true:
            reference = np.interp(time, true["time_s"], true["value"])
            moving = np.ones(len(time), bool)
        else:
            log = pandas.read_csv(out / name / "log.csv.gz")
            t, v = log["time_s"].to_numpy(), log["speed_mps"].to_numpy()
            s = np.interp(time, t, integral_of(t, v))
            reference = np.interp(s, true["distance_m"], true["value"])
            moving = np.interp(time, t, v) > MOVING
        estimate = got[column].to_numpy(dtype=float)
        found[column] = agreement(estimate[moving], reference[moving])
    return found


def named_above(row: Row, p: float) -> bool:
    """Tell whether a cause was named with more than a probability."""
    return any(x > p for x in row.get("probabilities", []) if isfinite(x))
