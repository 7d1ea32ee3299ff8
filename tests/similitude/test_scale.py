"""Scales: the paper's factors, there and back, and by the unit of a column."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from similar import car, truck

from rcc_sim.errors import InputError
from rcc_sim.similitude.scale import (
    QUANTITIES,
    SHAFT,
    Scales,
    scaled_quantity,
    scaled_vehicle,
)

NAMES = [*QUANTITIES, *SHAFT]


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("length", 0.09386),
        ("speed", 0.4160),
        ("time", 0.2256),
        ("distance", 1 / 10.65),
        ("energy_per_distance", 0.002211),
        ("steer", 1),
    ],
)
def test_the_scales_are_what_the_papers_inputs_give(name, factor):
    assert Scales.between(car(), truck()).of(name).value == pytest.approx(
        factor, rel=5e-3
    )


def test_the_papers_other_time_scale_is_that_of_the_stiffest_tyre():
    stiff = truck(tyres={"front_cornering_stiffness_n_per_rad": 50000})
    scales = Scales.between(car(), stiff)
    assert scales.of("time").value == pytest.approx(0.250, rel=5e-3)
    assert scales.of("speed").value == pytest.approx(0.375, rel=5e-3)


@pytest.mark.parametrize(
    ("kwh_per_mile", "wh_per_m"), [(0.48, 0.00066), (1.609344, 0.00221)]
)
def test_rated_consumption_at_the_cars_size(kwh_per_mile, wh_per_m):
    kwh_per_km = kwh_per_mile / 1.609344  # Wh/m of the truck
    scaled = scaled_quantity("energy_per_distance", kwh_per_km, to=car(), of=truck())
    assert scaled["value"] == pytest.approx(wh_per_m, rel=5e-3)


@given(name=st.sampled_from(NAMES), value=st.floats(-1e6, 1e6))
def test_there_and_back_is_the_identity(name, value):
    there = scaled_quantity(name, value, to=car(), of=truck())["value"]
    back = scaled_quantity(name, there, to=truck(), of=car())["value"]
    assert back == pytest.approx(value, rel=1e-12, abs=1e-300)


@pytest.mark.parametrize("name", NAMES)
def test_a_vehicle_against_itself_has_scale_one_exactly(name):
    assert tuple(Scales.between(truck(), truck()).of(name)) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize("name", NAMES)
def test_scales_of_scales_multiply(name):
    middle = scaled_vehicle(truck(), "middle", mass=0.3, length=0.6, force=0.4)
    one = Scales.between(car(), middle).of(name).value
    two = Scales.between(middle, truck()).of(name).value
    assert one * two == pytest.approx(Scales.between(car(), truck()).of(name).value)


def test_power_at_the_shaft_is_power_at_the_road():
    scales = Scales.between(car(), truck())
    shaft = scales.of("motor_torque").value * scales.of("motor_speed").value
    assert shaft == pytest.approx(scales.of("power").value)


def test_a_factor_has_the_interval_of_the_stiffness():
    wide = truck(
        tyres={
            "front_cornering_stiffness_n_per_rad": {
                "value": 40700,
                "low": 40000,
                "high": 50000,
            }
        }
    )
    factor = scaled_quantity("force", 1.0, to=car(), of=wide)
    assert factor["factor_low"] == pytest.approx(90 / 50000)
    assert factor["factor_high"] == pytest.approx(90 / 40000)


def test_a_column_is_scaled_by_its_unit_and_an_electrical_one_is_left_out():
    scales = Scales.between(car(), truck())
    table = {
        "time_s": 2.0,
        "throttle": 0.5,
        "battery_power_w": 1e4,
        "motor_current_a": 9.0,
    }
    scaled, left_out = scales.columns(table)
    assert left_out == ["motor_current_a"]
    assert scaled["throttle"] == 0.5
    assert scaled["time_s"] == pytest.approx(
        2 * math.sqrt(3.78 * 40700 * 0.32399 / (3152 * 90 * 3.452))
    )
    assert scaled["battery_power_w"] == pytest.approx(1e4 * scales.of("power").value)


@pytest.mark.parametrize("name", ["sped", "motor_current_a", ""])
def test_an_unknown_quantity_is_refused_with_what_there_is(name):
    with pytest.raises(InputError) as caught:
        scaled_quantity(name, 1.0, to=car(), of=truck())
    assert caught.value.hint
