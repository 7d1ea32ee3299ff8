"""The paper's values, intervals, and what the comparison says of them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from similar import car, truck

from rcc_sim.errors import InputError
from rcc_sim.similitude.pi import compare
from rcc_sim.similitude.quantities import figures_of, product
from rcc_sim.similitude.scale import scaled_vehicle


def by_name(comparison):
    return {row.name: row for row in (*comparison.groups, *comparison.more)}


@pytest.mark.parametrize(
    ("group", "of_car", "of_truck"),
    [
        ("pi_3", 0.490, 0.490),
        ("pi_6", 0.0963, 0.1331),
        ("pi_7", 1, 1),
        ("pi_12", 5.544e-6, 5.325e-6),
        ("pi_13", 3.440e-6, 1.377e-6),
    ],
)
def test_the_groups_are_what_the_papers_inputs_give(group, of_car, of_truck):
    row = by_name(compare([car(), truck()]))[group]
    assert [v.value for v in row.values] == pytest.approx([of_car, of_truck], rel=5e-3)


def test_a_range_becomes_an_interval():
    pi_6 = by_name(compare([car(), truck()]))["pi_6"].values[1]
    assert (pi_6.low, pi_6.high) == pytest.approx((0.1065, 0.1597), rel=5e-3)


def test_the_measured_inertia_gives_the_papers_other_value():
    heavier = car(body={"yaw_inertia_kgm2": 0.0389})
    pi_6 = by_name(compare([heavier]))["pi_6"].values[0]
    assert pi_6.value == pytest.approx(0.0979, rel=5e-3)


def test_the_verdict_names_what_differs_and_what_agrees():
    comparison = compare([car(), truck()])
    rows = by_name(comparison)
    assert [rows[n].verdict for n in ("pi_3", "pi_6", "pi_7", "pi_12", "pi_13")] == [
        "agree",
        "differ",
        "agree",
        "agree",
        "differ",
    ]
    assert comparison.verdict().startswith("not similar")
    assert "pi_13 (ratio 2.5)" in comparison.verdict()


def test_scales_hold_the_groups_of_the_repeating_variables_that_were_chosen():
    of_B = by_name(compare([car(), truck()], ("m", "l", "B")))
    m, l_, B = (
        figures_of(car()).known[s].value / figures_of(truck()).known[s].value
        for s in ("m", "l", "B")
    )
    assert of_B["pi_2"].ratio == pytest.approx(B**2 / (m**2 * l_**3))
    assert of_B["pi_8"].ratio == pytest.approx(m * l_**2 / B)
    assert of_B["pi_9"].ratio == pytest.approx(B / (m * l_))


def test_what_a_vehicle_does_not_state_is_null_with_the_reason():
    bare = car()
    bare = bare.changed(without=("rotor_inertia", "drivetrain_damping"))
    document = compare([bare, truck()]).document()
    group = {g["name"]: g for g in document["groups"]}["pi_12"]
    assert group["values"][0] is None
    assert "effects.rotor_inertia.inertia_kgm2" in group["note"]
    assert group["mismatch"]["verdict"] == "unknown"


def test_a_constant_efficiency_is_pi_5_and_a_map_is_not():
    stated = truck(effects={"motor_efficiency": {"scale": 0.9}})
    assert by_name(compare([stated]))["pi_5"].values[0].value == 0.9
    mapped = truck(effects={"motor_efficiency": {"scale": 0.9, "map": "m.csv"}})
    assert by_name(compare([mapped]))["pi_5"].values == (None,)


def test_scales_come_to_the_first_vehicle_from_each_other():
    document = compare([car(), truck(), car()]).document()
    assert len(document["scales_to_first"]) == 2
    assert document["scales"]["speed"] == pytest.approx(0.4160, rel=1e-3)
    assert document["scales_to_first"][1]["speed"] == 1.0
    assert "scales" not in compare([car()]).document()


@given(
    mass=st.floats(0.5, 2),
    length=st.floats(0.7, 1.4),
    force=st.floats(0.1, 10),
)
def test_a_vehicle_scaled_by_mass_length_and_force_keeps_its_groups(
    mass, length, force
):
    other = scaled_vehicle(truck(), "other", mass=mass, length=length, force=force)
    for row in (*compare([truck(), other]).groups, *compare([truck(), other]).more):
        if row.name in ("gravity", "friction"):
            continue  # gravity does not scale
        for one, two in [row.values]:
            assert (one is None) == (two is None)
            if one is not None:
                assert tuple(one) == pytest.approx(tuple(two), rel=1e-9)


@given(data=st.data())
def test_no_draw_from_the_figures_leaves_the_interval_of_a_group(data):
    vehicle = truck(body={"mass_kg": {"value": 3152, "sd": 100}, **FREE})
    figures = figures_of(vehicle)
    drawn = {
        s: i._replace(value=data.draw(st.floats(i.low, i.high)))
        for s, i in figures.known.items()
    }
    drawn["l"] = drawn["l"]._replace(value=drawn["l_F"].value + drawn["l_R"].value)
    for row in compare([vehicle]).groups:
        whole = product(figures, row.exponents)
        if whole is not None:
            value = product(figures._replace(known=drawn), row.exponents).value
            assert whole.low * (1 - 1e-12) <= value <= whole.high * (1 + 1e-12)


FREE = {"cg_to_front_axle_m": [1.6, 1.8], "cg_to_rear_axle_m": [1.7, 1.8]}


def test_an_effect_that_alters_a_figure_is_said_to_be_left_out():
    loaded = truck(effects={"payload": {"mass_kg": 500}})
    assert any("payload" in note for note in compare([loaded]).notes)


def test_a_figure_that_is_a_guess_shows():
    guessed = truck(
        body={"yaw_inertia_kgm2": {"value": 5000, "source": "guess: usual"}}
    )
    comparison = compare([car(), guessed])
    assert by_name(comparison)["pi_6"].guesses == (False, True)
    assert any("I_z" in note for note in comparison.notes)


def test_groups_of_no_vehicle_are_refused():
    with pytest.raises(InputError):
        compare([])
