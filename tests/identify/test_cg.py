"""Centre of gravity and ballast."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rcc_sim.errors import InputError
from rcc_sim.identify.cg import ballast, cg_from_balance, cg_from_scales, cg_height

RCC = {"m": 3.78, "l_F": 0.15876, "l": 0.32399}


def test_the_papers_car_weighs_1_93_kg_in_front():
    front = 3.78 * 0.16523 / 0.32399
    found = cg_from_scales(0.32399, front, 3.78 - front)
    assert (found.l_F, found.l_R) == pytest.approx((0.15876, 0.16523))
    assert found.m == pytest.approx(3.78)


@given(front=st.floats(0.1, 1e3), rear=st.floats(0.1, 1e3), l=st.floats(0.1, 4))
def test_moments_of_the_axle_weights_balance(front, rear, l):
    found = cg_from_scales(l, front, rear, scale_sd=0.01)
    assert found.l_F + found.l_R == pytest.approx(l)
    assert front * found.l_F == pytest.approx(rear * found.l_R)
    assert found.l_F_sd == pytest.approx(found.l_R_sd, rel=1e-4)


def test_a_balance_point_is_the_cg():
    found = cg_from_balance(0.324, 0.159, l_sd=0.001, balance_sd=0.002)
    assert (found.l_F, found.l_R) == pytest.approx((0.159, 0.165))
    assert found.l_R_sd == pytest.approx(math.hypot(0.001, 0.002))


@given(h=st.floats(0.03, 0.3), angle=st.floats(0.1, 1.0))
def test_the_tilted_axle_gives_the_height_back(h, angle):
    l, m, l_F, r_w = 0.324, 3.78, 0.159, 0.049
    level = m * (l - l_F) / l  # the front axle stays down
    raised = level + m * (h - r_w) * math.tan(angle) / l
    assume(raised > 0)
    found = cg_height(l, m, level, raised, l * math.sin(angle), r_w, scale_sd=0.002)
    assert found.value == pytest.approx(h)
    assert found.sd > 0


@given(
    mass=st.floats(0.05, 3),
    position=st.floats(0, 0.324),
    l_F=st.floats(0.05, 0.25),
)
def test_ballast_by_mass_and_by_position_agree(mass, position, l_F):
    target = (3.78 * l_F + mass * position) / (3.78 + mass)
    assume(abs(target - l_F) > 1e-6)
    by_place = ballast(3.78, l_F, 0.324, target, position=position, I_z=0.0389)
    by_mass = ballast(3.78, l_F, 0.324, target, mass=mass, reach=(-1, 1))
    assert by_place.mass == pytest.approx(mass, rel=1e-6)
    assert by_mass.position == pytest.approx(position, abs=1e-6)
    steiner = 3.78 * (target - l_F) ** 2 + mass * (position - target) ** 2
    assert by_place.I_z_change == pytest.approx(steiner, rel=1e-6, abs=1e-15)
    assert by_place.I_z == pytest.approx(0.0389 + steiner)


def test_at_the_target_no_mass_is_needed_and_any_mass_sits_on_it():
    assert ballast(**RCC, target=0.15876, position=0.3).mass == 0
    assert ballast(**RCC, target=0.15876, mass=1.0).position == pytest.approx(0.15876)


@pytest.mark.parametrize(
    ("given_", "message", "hint"),
    [
        (
            {"target": 0.18, "mass": 0.1},
            "would have to sit",
            "kg at 0.32399 m would do",
        ),
        ({"target": 0.18, "position": 0.1}, "no mass", "behind 0.18"),
        ({"target": 0.12, "position": 0.3}, "no mass", "ahead of 0.12"),
        ({"target": 0.18, "position": 300.0}, "should be from 0", "metres"),
        ({"target": 0.18}, "exactly one", ""),
        ({"target": 0.5, "mass": 1.0}, "less than", ""),
    ],
)
def test_what_cannot_be_reached_is_refused_with_the_way_out(given_, message, hint):
    with pytest.raises(InputError, match=message) as caught:
        ballast(**RCC, **given_)
    assert hint in caught.value.hint


@pytest.mark.parametrize(
    "call",
    [
        lambda: cg_from_scales(0.3, -1, 2),
        lambda: cg_from_scales(0.3, 1, 2, scale_sd=-1),
        lambda: cg_from_balance(0.3, 0.4),
        lambda: cg_height(0.3, 3.8, 2, 2.1, 0.4, 0.05),
        lambda: cg_height(0.3, 3.8, 2.1, 1.0, 0.05, 0.05),
    ],
)
def test_bad_input_is_refused(call):
    with pytest.raises(InputError):
        call()
