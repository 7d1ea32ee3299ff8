"""What would make one vehicle similar to another, and what that one should be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import require_positive
from rcc_sim.similitude.comparison import AGREE, WITHIN, Comparison, Row
from rcc_sim.similitude.pi import TOLERANCE, compare
from rcc_sim.similitude.quantities import KEYS, Figures, Interval, figures_of, product
from rcc_sim.similitude.workshop import CHANGE, OUT, WORDS, Frame

ARM = 0.75
"""How far from the CG masses are fixed unless said, in wheelbases. [1]"""

MATCHED, INSIDE, UNKNOWN = "matched", "inside the interval", "unknown"

ASKED = {"l_F": "pi_3", "I_z": "pi_6", "C_R": "pi_7", "J": "pi_12", "B": "pi_13"}
"""Symbol -> the paper's group that asks for it."""

OPTIONAL = {
    "m": "gravity",
    "h_cg": "cg_height",
    "w": "track_width",
    "r_w": "wheel_radius",
    "C_rr": "rolling_resistance",
    "C_dA": "drag",
    "P_aux": "auxiliaries",
}
"""Symbol -> the group beyond the paper's thirteen that asks for it."""


@dataclass(frozen=True)
class Change:
    """One figure: what it is, what it would have to be, how to get there.

    Parameters
    ----------
    symbol, group : str
        Paper's letter, and the group that asks for it.
    optional : bool
        Whether the group is beyond the paper's thirteen.
    now, needed : Interval or None
        As the vehicle states it, and what makes the group the other's.
    status : str
        "matched", "inside the interval", "change", "out of reach" or "unknown".
    how : str
        The change, or why it cannot be.
    other_has, other_instead : Interval or None
        What the other vehicle has, and what it would have to have for this vehicle,
        left as it is, to represent it.
    """

    symbol: str
    group: str
    optional: bool
    now: Interval | None
    needed: Interval | None
    status: str
    how: str
    other_has: Interval | None
    other_instead: Interval | None

    @property
    def open(self) -> bool:
        """Whether something stands between the vehicles here."""
        return self.status in (CHANGE, OUT)

    def row(self) -> dict[str, Any]:
        """Return it as a row of the table and of the JSON; the key has the unit."""
        now, needed, instead = self.now, self.needed, self.other_instead
        return {
            "symbol": self.symbol,
            "key": KEYS[self.symbol][-1],
            "group": self.group,
            "now": now and now.value,
            "needed": needed and needed.value,
            "needed_low": needed and needed.low,
            "needed_high": needed and needed.high,
            "change": needed.value - now.value if now and needed else None,
            "status": self.status,
            "optional": self.optional,
            "how": self.how,
            "other_has": self.other_has and self.other_has.value,
            "other_instead": instead and instead.value,
            "other_instead_low": instead and instead.low,
            "other_instead_high": instead and instead.high,
        }


@dataclass(frozen=True)
class Match:
    """Everything that stands between two vehicles and similarity.

    Parameters
    ----------
    vehicle, to : str
        The one to change, and the one to be similar to.
    arm : float
        Distance from the CG at which masses are thought to be fixed. [m]
    changes : tuple of Change
        One for each figure that a group asks for.
    notes : tuple of str
        What to beware of.
    wheelbase : float
        Of the one to change. [m]
    """

    vehicle: str
    to: str
    arm: float
    changes: tuple[Change, ...]
    notes: tuple[str, ...]
    wheelbase: float

    def settings(self) -> dict[str, float]:
        """Return key -> needed value of the paper's groups, for `Vehicle.changed`.

        The wheelbase stays: what l_F gains, l_R loses.
        """
        found = {
            c.symbol: c.needed.value
            for c in self.changes
            if c.needed is not None and not c.optional
        }
        settings = {KEYS[symbol][-1]: value for symbol, value in found.items()}
        settings[KEYS["l_R"][0]] = self.wheelbase - found["l_F"]
        return settings

    def verdict(self) -> str:
        """Return in a line what is to be done and what cannot be."""
        parts = []
        for status in (MATCHED, INSIDE, CHANGE, OUT, UNKNOWN):
            found = [
                c.symbol for c in self.changes if c.status == status and not c.optional
            ]
            if found:
                parts.append(f"{status}: {', '.join(found)}")
        return "; ".join(parts)

    def document(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        return {
            "vehicle": self.vehicle,
            "to": self.to,
            "arm_m": self.arm,
            "changes": self.rows(),
            "out_of_reach": [c.symbol for c in self.changes if c.status == OUT],
            "verdict": self.verdict(),
            "notes": list(self.notes),
        }

    def rows(self) -> list[dict[str, Any]]:
        """Return the table: one row a figure."""
        return [change.row() for change in self.changes]

    def lines(self) -> list[str]:
        """Return what a person should read beside the table."""
        lines = [f"{self.vehicle} to {self.to}: {self.verdict()}"]
        asked = [c for c in self.changes if c.open and not c.optional]
        beyond = [c for c in self.changes if c.open and c.optional]
        lines += [f"{c.symbol}: {c.how}" for c in asked]
        lines += [f"beyond the thirteen, {c.symbol}: {c.how}" for c in beyond]
        lines += [
            f"{self.vehicle} as it is stands for {self.to} with {c.symbol} "
            f"{_shown(c.other_instead)} in place of {_shown(c.other_has)}"
            for c in (*asked, *beyond)
            if c.other_instead and c.other_has
        ]
        return [*lines, *(f"note: {note}" for note in self.notes)]


def match(
    vehicle: Vehicle,
    to: Vehicle,
    arm: float | None = None,
    tolerance: float = TOLERANCE,
) -> Match:
    r"""Return what would make a vehicle similar to another.

    Mass, wheelbase and front tyres of each vehicle stay: they are the repeating
    variables, of which any value makes a scale. Every other figure x becomes

    .. math:: x = \pi_{other} \, m^a l^b C_F^c

    with the group of x as the other vehicle has it. Intervals are carried.

    Parameters
    ----------
    vehicle, to : Vehicle
        The one to change, and the one to be similar to.
    arm : float, optional
        Distance from the CG at which masses are fixed; `ARM` wheelbases unless
        given. [m]
    tolerance : float
        Share within which groups count as equal. [1]

    Raises
    ------
    InputError
        If ``arm`` is not positive.
    """
    arm = ARM * vehicle.wheelbase if arm is None else arm
    require_positive(arm=arm)
    comparison = compare([vehicle, to], tolerance=tolerance)
    mine, other = figures_of(vehicle), figures_of(to)
    rows = {row.name: row for row in (*comparison.groups, *comparison.more)}
    frame = _frame(mine, rows["pi_6"], arm)
    changes = [
        _change(symbol, rows[name], mine, other, frame, optional=asked is OPTIONAL)
        for asked in (ASKED, OPTIONAL)
        for symbol, name in asked.items()
        if name in rows
    ]
    return Match(
        vehicle=vehicle.name,
        to=to.name,
        arm=arm,
        changes=tuple(changes),
        notes=tuple(_notes(comparison, rows, other)),
        wheelbase=vehicle.wheelbase,
    )


def _frame(mine: Figures, pi_6: Row, arm: float) -> Frame:
    ratio = pi_6.values[1]
    assert ratio is not None, "every vehicle states its yaw inertia"
    return Frame(mine.known["m"].value, mine.known["l"].value, arm, ratio.value)


def _change(
    symbol: str,
    row: Row,
    mine: Figures,
    other: Figures,
    frame: Frame,
    *,
    optional: bool,
) -> Change:
    now, theirs = mine.known.get(symbol), other.known.get(symbol)
    needed = _solved(symbol, row, row.values[1], mine)
    if now is None or needed is None:
        status, how = UNKNOWN, row.note
    elif row.verdict == AGREE:
        status, how = MATCHED, "nothing to do"
    elif row.verdict == WITHIN:
        status, how = INSIDE, "nothing to do within what is known of both"
    else:
        status, how = WORDS[symbol](now, needed, frame)
    return Change(
        symbol=symbol,
        group=f"{row.name} = {row.formula}",
        optional=optional,
        now=now,
        needed=needed,
        status=status,
        how=how,
        other_has=theirs,
        other_instead=_solved(symbol, row, row.values[0], other),
    )


def _solved(
    symbol: str, row: Row, group: Interval | None, figures: Figures
) -> Interval | None:
    """Return the figure with which a vehicle would have a group's value."""
    rest = {s: -e for s, e in row.exponents.items() if s != symbol}
    others = product(figures, rest)
    if group is None or others is None:
        return None
    return Interval(*(g * o for g, o in zip(group, others, strict=True)))


def _notes(
    comparison: Comparison, rows: Mapping[str, Row], other: Figures
) -> list[str]:
    notes = list(comparison.notes)
    drive = rows["final_drive"]
    if drive.verdict not in (AGREE, WITHIN) and drive.ratio is not None:
        felt = [
            f"{symbol} of {_shown(solved)}"
            for symbol, name in (("J", "rotating_mass"), ("B", "road_damping"))
            if name in rows
            and (solved := _solved(symbol, rows[name], rows[name].values[0], other))
        ]
        words = f"; felt at the road, {other.name} would need {' and '.join(felt)}"
        notes.append(
            f"r_w/(N_d l) differs by the factor {drive.ratio:.3g}, which pi_12 and "
            f"pi_13 leave out{words if felt else ''}"
        )
    return notes


def _shown(number: Interval) -> str:
    if number.low == number.high:
        return f"{number.value:.4g}"
    return f"{number.value:.4g} ({number.low:.4g} to {number.high:.4g})"
