"""What is told of vehicles side by side: table, words, document."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from rcc_sim.similitude.dimensional import BY_SYMBOL, REPEATING, Exponents, rank
from rcc_sim.similitude.quantities import Interval
from rcc_sim.similitude.scale import Scales

AGREE, WITHIN, DIFFER, UNKNOWN = "agree", "not told apart", "differ", "unknown"


@dataclass(frozen=True)
class Row:
    """One group over all vehicles.

    Parameters
    ----------
    name, formula, what : str
        What it is called, how it is made, what it stands for.
    constant : bool
        Whether it is made of the vehicles' figures (else it varies over a drive).
    values : tuple of Interval or None
        One for each vehicle; None where it varies or a figure is not stated.
    guesses : tuple of bool
        Whether a guess is in it, for each vehicle.
    verdict : str
        "agree", "not told apart", "differ", "unknown", or empty where it varies or
        there is but one vehicle.
    ratio : float or None
        First vehicle's value over the second's, or the scale of the group's variable
        where it varies.
    note : str
        Why a value is missing.
    exponents : mapping of str to Fraction
        Symbol -> exponent.
    """

    name: str
    formula: str
    what: str
    constant: bool
    values: tuple[Interval | None, ...]
    guesses: tuple[bool, ...]
    verdict: str
    ratio: float | None
    note: str
    exponents: Exponents

    def document(self) -> dict[str, Any]:
        """Return what ``--json`` holds of it."""
        document: dict[str, Any] = {
            "name": self.name,
            "formula": self.formula,
            "what": self.what,
            "kind": "constant" if self.constant else "varying",
            "values": [v and v.value for v in self.values],
            "low": [v and v.low for v in self.values],
            "high": [v and v.high for v in self.values],
            "guess": list(self.guesses),
        }
        if self.constant:
            known = [v for v in self.values if v is not None]
            overlap = max((v.low for v in known), default=0.0) <= min(
                (v.high for v in known), default=0.0
            )
            both = len(known) == len(self.values) > 1
            document["mismatch"] = {
                "verdict": self.verdict or None,
                "ratio": self.ratio,
                "overlap": overlap if both else None,
            }
        else:
            document["scale"] = self.ratio
        return document | ({"note": self.note} if self.note else {})


@dataclass(frozen=True)
class Comparison:
    """Vehicles side by side.

    Parameters
    ----------
    names : tuple of str
        Of the vehicles.
    repeating : tuple of str
        Repeating variables.
    tolerance : float
        Share within which groups count as equal. [1]
    groups, more : tuple of Row
        The paper's thirteen; the groups beyond them that some vehicle states.
    scales : tuple of Scales
        To the first vehicle from each of the others.
    notes : tuple of str
        What to beware of.
    """

    names: tuple[str, ...]
    repeating: tuple[str, ...]
    tolerance: float
    groups: tuple[Row, ...]
    more: tuple[Row, ...]
    scales: tuple[Scales, ...]
    notes: tuple[str, ...]

    def verdict(self) -> str:
        """Return in words which groups agree and which do not."""
        if len(self.names) < 2:
            return ""
        said = {
            verdict: [r for r in self.groups if r.constant and r.verdict == verdict]
            for verdict in (AGREE, WITHIN, DIFFER, UNKNOWN)
        }
        head = "not similar" if said[DIFFER] else "similar"
        parts = []
        for verdict, rows in said.items():
            label = (
                f"agree to {100 * self.tolerance:g} %" if verdict == AGREE else verdict
            )
            words = ", ".join(_worded(row) for row in rows)
            if words:
                parts.append(f"{label}: {words}")
        return f"{head}; {'; '.join(parts)}"

    def document(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        document: dict[str, Any] = {
            "vehicles": list(self.names),
            "repeating": list(self.repeating),
            "rank": rank([variable.dimension for variable in BY_SYMBOL.values()]),
            "tolerance": self.tolerance,
            "groups": [row.document() for row in self.groups],
            "more": [row.document() for row in self.more],
        }
        if self.scales:
            first = self.scales[0].all()
            document |= {
                "scales": {name: factor.value for name, factor in first.items()},
                "scale_intervals": {n: [f.low, f.high] for n, f in first.items()},
                "scales_to_first": [
                    {"from": scales.second.name}
                    | {name: factor.value for name, factor in scales.all().items()}
                    for scales in self.scales
                ],
            }
        return document | {"verdict": self.verdict(), "notes": list(self.notes)}

    def rows(self) -> list[dict[str, Any]]:
        """Return the table: one row a group."""
        rows = []
        for row in (*self.groups, *self.more):
            cells: dict[str, Any] = {
                "group": row.name,
                "what": row.what,
                "formula": row.formula,
            }
            for label, value in zip(_labels(self.names), row.values, strict=True):
                cells |= {
                    label: value and value.value,
                    f"{label}_low": value and value.low,
                    f"{label}_high": value and value.high,
                }
            if self.scales:
                cells["ratio_or_scale"] = row.ratio
                cells["verdict"] = row.verdict if row.constant else "varies"
            rows.append(cells)
        return rows

    def shown(self) -> list[str]:
        """Name the columns that a terminal has room for."""
        keys = [k for k in self.rows()[0] if not k.endswith(("_low", "_high"))]
        return [k for k in keys if k != "formula" or len(self.names) == 1]

    def lines(self) -> list[str]:
        """Return what a person should read beside the table."""
        lines = []
        for scales in self.scales:
            named = ("length", "speed", "time", "force", "power", "energy_per_distance")
            factors = ", ".join(f"{n} {scales.of(n).value:.4g}" for n in named)
            names = f"{scales.second.name} × scale = {scales.first.name}"
            by = "" if self.repeating == REPEATING else f" by {', '.join(REPEATING)}"
            lines.append(f"scales{by} ({names}): {factors}")
        if self.scales:
            lines.append(self.verdict())
        return [*lines, *(f"note: {note}" for note in self.notes)]


def _worded(row: Row) -> str:
    if row.verdict not in (WITHIN, DIFFER) or row.ratio is None:
        return row.name
    shown = f"{row.ratio:.3g}" if math.isfinite(row.ratio) else "no number"
    return f"{row.name} (ratio {shown})"


def _labels(names: tuple[str, ...]) -> list[str]:
    return [
        name if names.count(name) == 1 else f"{name}_{i + 1}"
        for i, name in enumerate(names)
    ]
