"""The π-groups of vehicles side by side: which agree, which do not."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.similitude.comparison import (
    AGREE,
    DIFFER,
    UNKNOWN,
    WITHIN,
    Comparison,
    Row,
)
from rcc_sim.similitude.dimensional import (
    BY_SYMBOL,
    REPEATING,
    Exponents,
    Group,
    formula,
    pi_groups,
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


def _named(symbol: str) -> str:
    if symbol == "eta":
        return "effects.motor_efficiency.scale (eta then varies with torque and speed)"
    return KEYS[symbol][-1] if symbol in KEYS else symbol


def _leading(powers: Exponents) -> list[str]:
    return [symbol for symbol in powers if symbol not in REPEATING]


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
