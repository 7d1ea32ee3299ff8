"""The π-groups of vehicles side by side: which agree, which do not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.similitude.dimensional import (
    BY_SYMBOL,
    REPEATING,
    Exponents,
    Group,
    formula,
    pi_groups,
    rank,
)
from rcc_sim.similitude.quantities import (
    CHANGED_BY,
    KEYS,
    Figures,
    Interval,
    figures_of,
    product,
)
from rcc_sim.similitude.scale import Scales

TOLERANCE = 0.05
"""Groups that differ by less than this share are called equal. [1]"""

AGREE, WITHIN, DIFFER, UNKNOWN = "agree", "not told apart", "differ", "unknown"


def _powers(**exponents: float) -> dict[str, Fraction]:
    return {symbol: Fraction(e) for symbol, e in exponents.items()}


MORE: tuple[tuple[str, str, dict[str, Fraction]], ...] = (
    ("gravity", "weight over tyre stiffness", _powers(g=1, m=1, C_F=-1)),
    ("cg_height", "load transfer", _powers(h_cg=1, l=-1)),
    ("track_width", "roll, turning", _powers(w=1, l=-1)),
    ("friction", "grip over tyre stiffness", _powers(mu=1, g=1, m=1, C_F=-1)),
    ("wheel_radius", "tyre size", _powers(r_w=1, l=-1)),
    ("final_drive", "distance per shaft turn", _powers(r_w=1, N_d=-1, l=-1)),
    ("rotating_mass", "J as felt at the road", _powers(J=1, N_d=2, r_w=-2, m=-1)),
    (
        "road_damping",
        "B as felt at the road",
        _powers(B=1, N_d=2, r_w=-2, l=0.5, C_F=-0.5, m=-0.5),
    ),
    ("dry_friction", "driveline", _powers(T_C=1, N_d=1, r_w=-1, C_F=-1)),
    ("rolling_resistance", "tyres", _powers(C_rr=1, g=1, m=1, C_F=-1)),
    ("drag", "air, less the half", _powers(rho=1, C_dA=1, l=1, m=-1)),
    ("road_load_a", "certified A", _powers(F_0=1, C_F=-1)),
    ("road_load_b", "certified B", _powers(F_1=1, l=0.5, C_F=-0.5, m=-0.5)),
    ("road_load_c", "certified C", _powers(F_2=1, l=1, m=-1)),
    ("auxiliaries", "auxiliary load", _powers(P_aux=1, m=0.5, C_F=-1.5, l=-0.5)),
)
"""Name, what, powers: groups of figures that the paper's thirteen leave out."""


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


def compare(
    vehicles: Sequence[Vehicle],
    repeating: Sequence[str] = REPEATING,
    tolerance: float = TOLERANCE,
) -> Comparison:
    """Return the π-groups of vehicles side by side.

    Parameters
    ----------
    vehicles : sequence of Vehicle
        At least one; scales and ratios are to the first from each other.
    repeating : sequence of str
        Three variables that span mass, length and time.
    tolerance : float
        Share within which groups count as equal. [1]

    Raises
    ------
    InputError
        If the repeating variables do not do, or there is no vehicle.
    """
    if not vehicles:
        raise InputError("should be given at least one vehicle")
    figures = [figures_of(vehicle) for vehicle in vehicles]
    scales = tuple(Scales.between(vehicles[0], other) for other in vehicles[1:])
    groups = tuple(
        _group_row(group, figures, tolerance) for group in pi_groups(repeating)
    )
    more = tuple(
        _row(
            name,
            formula(powers, lead=_leading(powers)),
            what,
            powers,
            figures,
            tolerance,
        )
        for name, what, powers in MORE
        if any(not f.missing(powers) for f in figures)
    )
    return Comparison(
        names=tuple(vehicle.name for vehicle in vehicles),
        repeating=tuple(repeating),
        tolerance=tolerance,
        groups=groups,
        more=more,
        scales=scales,
        notes=tuple(note for v in vehicles for note in _notes(v)),
    )


def _group_row(group: Group, figures: list[Figures], tolerance: float) -> Row:
    if group.constant:
        return _row(
            group.name,
            group.formula,
            group.variable.what,
            group.exponents,
            figures,
            tolerance,
        )
    return Row(
        name=group.name,
        formula=group.formula,
        what=group.variable.what,
        constant=False,
        values=(None,) * len(figures),
        guesses=(False,) * len(figures),
        verdict="",
        ratio=_scale(group, *figures[:2]) if len(figures) > 1 else None,
        note="varies over a drive; --trace writes it over time",
        exponents=group.exponents,
    )


def _scale(group: Group, first: Figures, second: Figures) -> float | None:
    """Return what a group that varies makes of its variable, from second to first.

    The group being the same, it is the ratio of the repeating variables that are in it.
    """
    powers = dict(group.exponents)
    own = powers.pop(group.variable.symbol)
    powers = {symbol: -exponent / own for symbol, exponent in powers.items()}
    mine, others = product(first, powers), product(second, powers)
    return None if mine is None or others is None else mine.over(others).value


def _row(
    name: str,
    text: str,
    what: str,
    exponents: Exponents,
    figures: list[Figures],
    tolerance: float,
) -> Row:
    values = tuple(product(f, exponents) for f in figures)
    known = [value for value in values if value is not None]
    ratio = None
    if len(values) > 1 and values[0] is not None and values[1] is not None:
        ratio = values[0].over(values[1]).value
    absent = [
        f"{f.name}: {_named(symbol)}"
        for f in figures
        for symbol in f.missing(exponents)
    ]
    return Row(
        name=name,
        formula=text,
        what=what,
        constant=True,
        values=values,
        guesses=tuple(bool(f.guesses & set(exponents)) for f in figures),
        verdict=_verdict(known, len(values), tolerance),
        ratio=ratio,
        note=f"not stated: {'; '.join(absent)}" if absent else "",
        exponents=exponents,
    )


def _verdict(known: list[Interval], count: int, tolerance: float) -> str:
    if count < 2:
        return ""
    if len(known) < count:
        return UNKNOWN
    least, most = min(v.value for v in known), max(v.value for v in known)
    if most == least or most - least <= tolerance * max(abs(least), abs(most)):
        return AGREE
    overlap = max(v.low for v in known) <= min(v.high for v in known)
    return WITHIN if overlap else DIFFER


def _worded(row: Row) -> str:
    if row.verdict not in (WITHIN, DIFFER) or row.ratio is None:
        return row.name
    shown = f"{row.ratio:.3g}" if math.isfinite(row.ratio) else "no number"
    return f"{row.name} (ratio {shown})"


def _named(symbol: str) -> str:
    if symbol == "eta":
        return "effects.motor_efficiency.scale (eta then varies with torque and speed)"
    return KEYS[symbol][-1] if symbol in KEYS else symbol


def _leading(powers: Exponents) -> list[str]:
    return [symbol for symbol in powers if symbol not in REPEATING]


def _labels(names: tuple[str, ...]) -> list[str]:
    return [
        name if names.count(name) == 1 else f"{name}_{i + 1}"
        for i, name in enumerate(names)
    ]


def _notes(vehicle: Vehicle) -> list[str]:
    notes = []
    figures = figures_of(vehicle)
    wanted = [s for s in KEYS if s in figures.guesses and s in BY_SYMBOL]
    if wanted:
        notes.append(f"{vehicle.name}: guesses are {', '.join(wanted)}")
    ignored = [name for name in CHANGED_BY if name in vehicle.effects]
    if ignored:
        notes.append(
            f"{vehicle.name}: the groups take the file's figures, before "
            f"its effects {', '.join(ignored)}"
        )
    return notes
