"""What `match` asks for makes the vehicles similar."""

from __future__ import annotations

import pytest
from similar import car, truck

from rcc_sim.errors import InputError
from rcc_sim.similitude.match import match
from rcc_sim.similitude.pi import compare
from rcc_sim.similitude.workshop import Frame, mass_at_arms


def changes(result):
    return {change.symbol: change for change in result.changes}


def test_the_settings_asked_for_make_every_group_the_others():
    other = truck(
        body={"cg_to_front_axle_m": 1.5, "cg_to_rear_axle_m": 1.9},
        tyres={"rear_cornering_stiffness_n_per_rad": 55000},
    )
    changed = car().changed(settings=match(car(), other).settings())
    verdicts = {r.name: r for r in compare([changed, other]).groups if r.constant}
    for name in ("pi_3", "pi_6", "pi_7", "pi_12", "pi_13"):
        assert verdicts[name].ratio == pytest.approx(1, rel=1e-9)


def test_the_truck_that_the_car_stands_for_is_the_papers():
    found = changes(match(car(), truck()))
    assert found["B"].other_instead.value == pytest.approx(0.2499, rel=5e-3)
    assert found["I_z"].other_instead.value == pytest.approx(3616, rel=5e-3)
    assert found["J"].other_instead.value == pytest.approx(0.2083, rel=5e-3)


def test_damping_below_the_cars_own_is_out_of_reach():
    found = changes(match(car(), truck()))["B"]
    assert found.status == "out of reach"
    assert found.needed.value < found.now.value


def test_masses_fore_and_aft_count_their_own_weight():
    frame = Frame(m=3.78, l=0.324, arm=0.25, ratio=0.1331)
    added = mass_at_arms(0.0382, frame)
    ratio = (0.0382 + added * 0.25**2) / ((3.78 + added) * 0.324**2)
    assert ratio == pytest.approx(0.1331)


def test_masses_too_near_the_cg_do_not_help():
    assert mass_at_arms(0.0382, Frame(m=3.78, l=0.324, arm=0.1, ratio=0.1331)) is None
    assert changes(match(car(), truck(), arm=0.1))["I_z"].status == "out of reach"


def test_ballast_is_never_negative():
    light = truck(tyres={"front_cornering_stiffness_n_per_rad": 80000})
    ballast = changes(match(car(), light))["m"]
    assert ballast.needed.value < ballast.now.value
    assert ballast.status == "out of reach"


def test_moving_the_cg_says_how_far_and_which_way():
    ahead = truck(body={"cg_to_front_axle_m": 1.6, "cg_to_rear_axle_m": 1.852})
    how = changes(match(car(), ahead))["l_F"].how
    assert "mm forward" in how


def test_a_vehicle_against_itself_has_nothing_to_change():
    result = match(truck(), truck())
    assert {c.status for c in result.changes} <= {"matched"}


def test_what_is_not_stated_is_unknown_not_an_error():
    bare = car().changed(without=("drivetrain_damping",))
    assert changes(match(bare, truck()))["B"].status == "unknown"


def test_an_arm_of_no_length_is_refused():
    with pytest.raises(InputError):
        match(car(), truck(), arm=0.0)
