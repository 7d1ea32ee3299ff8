"""The π-groups are dimensionless, thirteen, ordered, and the paper's."""

from __future__ import annotations

import math
from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcc_sim.errors import InputError
from rcc_sim.similitude.dimensional import (
    BY_SYMBOL,
    OF_SUFFIX,
    VARIABLES,
    check_repeating,
    dimension_of,
    pi_groups,
    rank,
)
from rcc_sim.similitude.pi import MORE
from rcc_sim.units import SUFFIXES

PAPER = [
    "delta",
    "m a/C_F",
    "l_F/l",
    "E_b/(C_F l)",
    "eta",
    "I_z/(m l^2)",
    "C_R/C_F",
    "t sqrt(C_F/(m l))",
    "v_x sqrt(m/(C_F l))",
    "v_y sqrt(m/(C_F l))",
    "r sqrt(m l/C_F)",
    "J/(m l^2)",
    "B/sqrt(C_F m l^3)",
]


def sound_choices() -> list[tuple[str, str, str]]:
    """Return every choice of three repeating variables that spans the dimensions."""
    return [
        chosen
        for chosen in combinations(BY_SYMBOL, 3)
        if rank([BY_SYMBOL[s].dimension for s in chosen]) == 3
    ]


def test_the_groups_are_the_papers_in_its_order():
    assert [group.formula for group in pi_groups()] == PAPER
    assert [group.name for group in pi_groups()] == [f"pi_{i}" for i in range(1, 14)]


@pytest.mark.parametrize("repeating", sound_choices(), ids="-".join)
def test_every_sound_choice_gives_thirteen_groups_that_span_the_same_space(repeating):
    chosen, default = pi_groups(repeating), pi_groups()
    assert len(chosen) == 13
    rows = [
        tuple(group.exponents.get(v.symbol, 0) for v in VARIABLES)
        for group in (*default, *chosen)
    ]
    assert rank(rows[:13]) == rank(rows[13:]) == rank(rows) == 13


@given(units=st.tuples(*[st.floats(1e-3, 1e3)] * 3), data=st.data())
def test_a_group_keeps_its_value_when_the_units_change(units, data):
    group = data.draw(st.sampled_from(pi_groups(data.draw(st.sampled_from(CHOICES)))))
    change = sum(
        float(e) * sum(d * math.log(u) for d, u in zip(dimension, units, strict=True))
        for symbol, e in group.exponents.items()
        for dimension in [BY_SYMBOL[symbol].dimension]
    )
    assert change == pytest.approx(0, abs=1e-9)


CHOICES = sound_choices()

KEY_DIMENSION = {
    "g": (0, 1, -2),
    "h_cg": (0, 1, 0),
    "w": (0, 1, 0),
    "mu": (0, 0, 0),
    "r_w": (0, 1, 0),
    "N_d": (0, 0, 0),
    "T_C": (1, 2, -2),
    "C_rr": (0, 0, 0),
    "C_dA": (0, 2, 0),
    "rho": (1, -3, 0),
    "F_0": (1, 1, -2),
    "F_1": (1, 0, -1),
    "F_2": (1, -1, 0),
    "P_aux": (1, 2, -3),
} | {symbol: tuple(v.dimension) for symbol, v in BY_SYMBOL.items()}


@pytest.mark.parametrize(("name", "what", "powers"), MORE, ids=[m[0] for m in MORE])
def test_the_groups_beyond_the_thirteen_are_dimensionless_too(name, what, powers):
    assert what
    for axis in range(3):
        assert sum(e * KEY_DIMENSION[s][axis] for s, e in powers.items()) == 0


def test_every_unit_of_an_edge_name_has_a_dimension_or_none():
    assert set(OF_SUFFIX) == set(SUFFIXES)
    assert dimension_of("battery_power_w") == (1, 2, -3)
    assert dimension_of("motor_current_a") is None
    assert dimension_of("throttle") == (0, 0, 0)


@pytest.mark.parametrize(
    ("repeating", "says"),
    [
        (("m", "l", "I_z"), "rank 2; I_z has the dimension of m l^2"),
        (("m", "delta", "l"), "delta is dimensionless"),
        (("C_F", "C_R", "m"), "C_R has the dimension of C_F"),
        (("m", "l"), "2 given, of rank 2"),
        (("m", "l", "C_F", "J"), "J has the dimension of m l^2"),
        (("m", "l", "mass"), "no such variable: mass"),
    ],
)
def test_a_choice_that_does_not_span_says_which_depends_on_which(repeating, says):
    with pytest.raises(InputError, match=says.replace("^", r"\^")):
        check_repeating(repeating)
