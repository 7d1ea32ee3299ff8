"""Buckingham's theorem in exact arithmetic: variables, dimensions, π-groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

from rcc_sim.errors import InputError
from rcc_sim.units import SUFFIXES, unit_of


class Dimension(NamedTuple):
    """Exponents of mass, length and time."""

    mass: int
    length: int
    time: int


NONE = Dimension(0, 0, 0)
MASS = Dimension(1, 0, 0)
LENGTH = Dimension(0, 1, 0)
TIME = Dimension(0, 0, 1)
RATE = Dimension(0, 0, -1)
SPEED = Dimension(0, 1, -1)
ACCELERATION = Dimension(0, 1, -2)
FORCE = Dimension(1, 1, -2)
ENERGY = Dimension(1, 2, -2)
POWER = Dimension(1, 2, -3)
INERTIA = Dimension(1, 2, 0)
DAMPING = Dimension(1, 2, -1)

OF_SUFFIX: dict[str, Dimension | None] = {
    "n_s2_per_m2": Dimension(1, -1, 0),
    "n_s_per_m": Dimension(1, 0, -1),
    "nms_per_rad": DAMPING,
    "n_per_rad": FORCE,
    "kg_per_m3": Dimension(1, -3, 0),
    "wh_per_km": FORCE,
    "kgm2": INERTIA,
    "mps2": ACCELERATION,
    "radps": RATE,
    "erpm": RATE,
    "percent": NONE,
    "per_h": RATE,
    "mps": SPEED,
    "rad": NONE,
    "nm": ENERGY,
    "wh": ENERGY,
    "hz": RATE,
    "kg": MASS,
    "m2": Dimension(0, 2, 0),
    "m": LENGTH,
    "s": TIME,
    "n": FORCE,
    "w": POWER,
    "j": ENERGY,
    **dict.fromkeys(
        (
            "as_per_rad",
            "a_per_rad",
            "rpm_per_v",
            "degc",
            "ohm",
            "ah",
            "wb",
            "v",
            "a",
            "h",
        )
    ),
}
"""Unit suffix of an edge name -> its dimension; None if it is electrical or thermal."""

_OF_UNIT = {"1": NONE} | {SUFFIXES[s]: d for s, d in OF_SUFFIX.items()}


def dimension_of(column: str) -> Dimension | None:
    """Return the dimension of an edge name's unit; None if M, L, T do not make it up.

    >>> dimension_of("battery_power_w")
    Dimension(mass=1, length=2, time=-3)
    """
    return _OF_UNIT[unit_of(column)]


class Variable(NamedTuple):
    """A quantity of the analysis.

    Attributes
    ----------
    symbol : str
        The paper's letter.
    dimension : Dimension
        Exponents of mass, length, time.
    constant : bool
        Whether it is a figure of the vehicle (else it varies over a drive).
    what : str
        What it is, in words.
    """

    symbol: str
    dimension: Dimension
    constant: bool
    what: str


VARIABLES: tuple[Variable, ...] = (
    Variable("delta", NONE, False, "steer angle"),
    Variable("a", ACCELERATION, False, "longitudinal acceleration"),
    Variable("l_F", LENGTH, True, "CG to front axle"),
    Variable("E_b", ENERGY, False, "battery energy"),
    Variable("eta", NONE, True, "powertrain efficiency"),
    Variable("I_z", INERTIA, True, "yaw inertia"),
    Variable("C_R", FORCE, True, "cornering stiffness of a rear tyre"),
    Variable("t", TIME, False, "time"),
    Variable("v_x", SPEED, False, "longitudinal speed"),
    Variable("v_y", SPEED, False, "lateral speed"),
    Variable("r", RATE, False, "yaw rate"),
    Variable("J", INERTIA, True, "inertia at the motor shaft"),
    Variable("B", DAMPING, True, "damping at the motor shaft"),
    Variable("m", MASS, True, "mass"),
    Variable("l", LENGTH, True, "wheelbase"),
    Variable("C_F", FORCE, True, "cornering stiffness of a front tyre"),
)
"""The paper's sixteen, in the order in which it numbers their groups."""

BY_SYMBOL = {variable.symbol: variable for variable in VARIABLES}
REPEATING = ("m", "l", "C_F")
"""Repeating variables unless others are chosen."""

Exponents = Mapping[str, Fraction]
_WRITTEN_FIRST = ("C_F", "m", "l")


class Group(NamedTuple):
    """A dimensionless product of powers.

    Attributes
    ----------
    name : str
        ``pi_6``, counted from 1 in the order of `VARIABLES`.
    variable : Variable
        The quantity that the group is of; its exponent is 1.
    exponents : mapping of str to Fraction
        Symbol -> exponent.
    formula : str
        The same, to be read: ``I_z/(m l^2)``.
    """

    name: str
    variable: Variable
    exponents: Exponents
    formula: str

    @property
    def constant(self) -> bool:
        """Whether it is made of the vehicle's figures alone."""
        return all(BY_SYMBOL[symbol].constant for symbol in self.exponents)


def pi_groups(repeating: Sequence[str] = REPEATING) -> tuple[Group, ...]:
    r"""Return the π-groups of `VARIABLES` for a choice of repeating variables.

    .. math:: \pi_i = x_i \prod_j q_j^{-e_{ij}}, \quad D_q e_i = d_i

    with the exponents solved exactly. [1]_

    Raises
    ------
    InputError
        If a symbol is unknown, or the choice does not span mass, length and time.

    References
    ----------
    .. [1] E. Buckingham, "On physically similar systems," Phys. Rev. 4 (1914) 345.
    """
    check_repeating(repeating)
    groups: list[Group] = []
    for variable in VARIABLES:
        if variable.symbol in repeating:
            continue
        powers = exponents_of(variable.dimension, repeating)
        exponents = {variable.symbol: Fraction(1)}
        exponents |= {symbol: -e for symbol, e in powers.items() if e}
        name = f"pi_{len(groups) + 1}"
        text = formula(exponents, lead=(variable.symbol,))
        groups.append(Group(name, variable, exponents, text))
    return tuple(groups)


def exponents_of(dimension: Dimension, repeating: Sequence[str]) -> dict[str, Fraction]:
    """Return the powers of the repeating variables whose product has a dimension."""
    solved = _expressed(dimension, [BY_SYMBOL[s].dimension for s in repeating])
    assert solved is not None, "the repeating variables were checked"
    return dict(zip(repeating, solved, strict=True))


def check_repeating(repeating: Sequence[str]) -> None:
    """Raise unless the symbols are known and span the three dimensions.

    Raises
    ------
    InputError
        Naming the rank, and the first variable that the ones before it already hold.
    """
    given = f"--repeating {','.join(repeating)}"
    for symbol in repeating:
        if symbol not in BY_SYMBOL:
            raise InputError(
                f"{given}: no such variable: {symbol}",
                f"there are {', '.join(BY_SYMBOL)}",
            )
    dimensions = [BY_SYMBOL[symbol].dimension for symbol in repeating]
    full, found = rank([v.dimension for v in VARIABLES]), rank(dimensions)
    if found == len(repeating) == full:
        return
    message = f"{given}: should be {full} variables that span mass, length and time"
    if found == len(repeating):
        raise InputError(f"{message}: {len(repeating)} given, of rank {found}")
    raise InputError(
        f"{message}: rank {found}; {_dependence(repeating, dimensions)}",
        f"the paper takes {','.join(REPEATING)}",
    )


def _dependence(symbols: Sequence[str], dimensions: Sequence[Dimension]) -> str:
    for i, (symbol, dimension) in enumerate(zip(symbols, dimensions, strict=True)):
        powers = _expressed(dimension, dimensions[:i])
        if powers is None:
            continue
        held = {s: e for s, e in zip(symbols, powers, strict=False) if e}
        if not held:
            return f"{symbol} is dimensionless"
        return f"{symbol} has the dimension of {formula(held, lead=())}"
    raise AssertionError("independent after all")


def rank(dimensions: Sequence[Dimension]) -> int:
    """Return how many of the dimensions are independent."""
    kept: list[Dimension] = []
    for dimension in dimensions:
        if _expressed(dimension, kept) is None:
            kept.append(dimension)
    return len(kept)


def _expressed(
    target: Sequence[int], basis: Sequence[Sequence[int]]
) -> list[Fraction] | None:
    """Solve basis · e = target by elimination; None if there is no solution."""
    n = len(basis)
    rows = [
        [Fraction(vector[i]) for vector in basis] + [Fraction(target[i])]
        for i in range(len(target))
    ]
    pivots: list[int] = []
    for column in range(n):
        at = len(pivots)
        pivot = next((i for i in range(at, len(rows)) if rows[i][column]), None)
        if pivot is None:
            continue
        rows[at], rows[pivot] = rows[pivot], rows[at]
        rows[at] = [x / rows[at][column] for x in rows[at]]
        for i, row in enumerate(rows):
            if i != at and row[column]:
                rows[i] = [
                    x - row[column] * y for x, y in zip(row, rows[at], strict=True)
                ]
        pivots.append(column)
    if any(row[n] for row in rows[len(pivots) :]):
        return None
    solution = [Fraction(0)] * n
    for i, column in enumerate(pivots):
        solution[column] = rows[i][n]
    return solution


def formula(exponents: Exponents, lead: Sequence[str]) -> str:
    """Write a product of powers: ``B/sqrt(C_F m l^3)``, ``m a/C_F``.

    ``lead`` are the symbols that stay outside a square root, in their order.
    """
    rest = {s: e for s, e in sorted(exponents.items(), key=_place) if s not in lead}
    own = {s: exponents[s] for s in lead}
    halves = {e.denominator for e in rest.values()} == {2} or (
        {e.denominator for e in rest.values()} == {1, 2}
    )
    if not halves:
        return _fraction(rest | own)
    above, below = _sides({s: 2 * e for s, e in rest.items()})
    if above:
        return (
            f"{_fraction(own)} sqrt({_fraction({s: 2 * e for s, e in rest.items()})})"
        )
    over, under = _sides(own)
    root = f"sqrt({' '.join(below)})"
    under = [*under, root]
    return f"{' '.join(over) or '1'}/{under[0] if len(under) == 1 else _bracket(under)}"


def _place(item: tuple[str, Fraction]) -> tuple[int, int]:
    symbol = item[0]
    if symbol in _WRITTEN_FIRST:
        return 0, _WRITTEN_FIRST.index(symbol)
    known = list(BY_SYMBOL)
    return 1, known.index(symbol) if symbol in known else len(known)


def _sides(exponents: Exponents) -> tuple[list[str], list[str]]:
    above = [_power(s, e) for s, e in exponents.items() if e > 0]
    below = [_power(s, -e) for s, e in exponents.items() if e < 0]
    return above, below


def _fraction(exponents: Exponents) -> str:
    above, below = _sides(exponents)
    top = " ".join(above) or "1"
    if not below:
        return top
    return f"{top}/{below[0] if len(below) == 1 else _bracket(below)}"


def _bracket(parts: Sequence[str]) -> str:
    return f"({' '.join(parts)})"


def _power(symbol: str, e: Fraction) -> str:
    if e == 1:
        return symbol
    return f"{symbol}^{e}" if e.denominator == 1 else f"{symbol}^({e})"
