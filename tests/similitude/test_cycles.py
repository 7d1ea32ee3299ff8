"""Scaled cycles keep their shape; clips and limits say what they took."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from similar import car, truck

from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.errors import InputError
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.similitude.demand import demand
from rcc_sim.similitude.limits import drive_limits

SPEEDS = st.lists(st.floats(0, 30), min_size=3, max_size=40)


def cycle_of(speeds, step=1.0):
    return Cycle("made", np.arange(len(speeds)) * step, np.array(speeds))


def limit(vehicle, cycle, what):
    return next(x for x in drive_limits(vehicle, cycle) if x.what == what)


def test_the_scaled_udds_has_the_papers_speed_and_time():
    scaled = scale_cycle(parse_cycle("udds"), to=car(), of=truck()).cycle
    assert scaled.max_speed == pytest.approx(25.347 * 0.41601, rel=5e-3)
    assert scaled.duration == pytest.approx(1369 * 0.22561, rel=5e-3)


@given(speeds=SPEEDS)
def test_a_cycle_scaled_there_and_back_is_the_cycle(speeds):
    cycle = cycle_of(speeds)
    there = scale_cycle(cycle, to=car(), of=truck()).cycle
    back = scale_cycle(there, to=truck(), of=car()).cycle
    assert back.speed_mps == pytest.approx(cycle.speed_mps, rel=1e-12, abs=1e-300)
    assert back.time_s == pytest.approx(cycle.time_s, rel=1e-12)


@given(speeds=SPEEDS)
def test_distance_scales_as_length(speeds):
    cycle = cycle_of(speeds)
    result = scale_cycle(cycle, to=car(), of=truck())
    length = result.scales.of("length").value
    assert result.cycle.distance == pytest.approx(cycle.distance * length, abs=1e-12)


@given(speeds=SPEEDS, top=st.floats(0.5, 15), accel=st.floats(0.1, 10))
def test_clips_keep_both_limits_and_never_go_faster_than_the_cycle(speeds, top, accel):
    free = scale_cycle(cycle_of(speeds), to=car(), of=truck())
    result = scale_cycle(
        cycle_of(speeds), to=car(), of=truck(), max_speed=top, max_accel=accel
    )
    assert result.cycle.max_speed <= top
    assert result.cycle.max_acceleration <= accel * (1 + 1e-9)
    assert result.cycle.max_deceleration <= accel * (1 + 1e-9)
    assert (result.cycle.speed_mps <= free.cycle.speed_mps).all()
    lost = sum(clip.distance for clip in result.clips)
    assert free.cycle.distance - lost == pytest.approx(result.cycle.distance, abs=1e-9)


def test_a_clip_that_takes_nothing_says_so():
    result = scale_cycle(cycle_of([0, 1, 0]), to=car(), of=truck(), max_speed=9.0)
    assert result.clips[0].seconds == 0
    assert "nothing to clip" in result.clips[0].line()


def test_resampling_gives_the_rate_asked_for():
    result = scale_cycle(cycle_of([0, 5, 9, 0]), to=car(), of=truck(), rate=100.0).cycle
    assert np.diff(result.time_s) == pytest.approx(0.01)
    assert result.distance == pytest.approx(
        scale_cycle(cycle_of([0, 5, 9, 0]), to=car(), of=truck()).cycle.distance,
        rel=1e-3,
    )


def test_a_short_track_ends_the_cycle_at_its_last_stop():
    cycle = cycle_of([0, 10, 10, 0, 0, 10, 10, 10, 0])
    result = scale_cycle(cycle, to=car(), of=truck(), track_length=3.0)
    assert result.cycle.speed_mps[-1] == 0
    assert result.cycle.distance <= 3.0
    assert result.track.cut == pytest.approx(4 * result.scales.of("time").value)
    assert "cut at its last stop" in result.track.line()


def test_a_track_without_a_stop_on_it_cuts_nothing_and_says_so():
    cycle = cycle_of([0, 10, 10, 10, 0])
    result = scale_cycle(cycle, to=car(), of=truck(), track_length=1.0)
    assert result.track.cut is None
    assert len(result.rows()) == 5
    assert "nothing was cut" in result.track.line()


@pytest.mark.parametrize("option", ["rate", "max_speed", "max_accel", "track_length"])
def test_an_option_that_is_not_positive_is_refused(option):
    with pytest.raises(InputError, match=option.replace("_", "-")):
        scale_cycle(cycle_of([0, 1, 0]), to=car(), of=truck(), **{option: 0.0})


def test_the_top_speed_is_that_of_the_erpm_limit():
    found = limit(car(), cycle_of([14.0, 14.0, 12.0]), "top speed")
    assert found.limit == pytest.approx(6283.2 / 2 * 0.049 / 11.82)
    assert found.seconds == 2.0


def test_the_torque_asked_is_newtons_law_with_the_turning_parts():
    cycle = cycle_of([0.0, 3.0])
    n = 11.82 / 0.049
    by_hand = 3.78 * 3 / n + 2.2e-6 * 3 * n + 1.17e-5 * 1.5 * n
    assert demand(car(), cycle).tau[0] == pytest.approx(by_hand)


def test_a_harder_acceleration_than_the_current_allows_is_said():
    assert limit(car(), cycle_of([0.0, 12.0]), "motor torque").exceeded
    assert not limit(car(), cycle_of([0.0, 1.0]), "motor torque").exceeded


def test_a_car_without_regeneration_cannot_brake_harder_than_it_coasts():
    still = car(effects={"regeneration_limit": {"max_current_a": 0.0}})
    found = limit(still, cycle_of([5.0, 1.0, 1.0]), "braking")
    assert found.seconds == 1.0
    assert found.asked == pytest.approx(4.0)
    n = 11.82 / 0.049
    coast = 1.17e-5 * n * n * 3.0 / (3.78 + 2.2e-6 * n * n)
    assert found.limit == pytest.approx(coast)


def test_speeds_in_the_dead_zone_are_counted_and_standstill_is_not():
    shy = car(effects={"speed_dead_zone": {"threshold_radps": 41.9}})
    found = limit(shy, cycle_of([0, 0, 0.1, 0.1, 3, 3]), "dead zone")
    assert found.seconds == 2.0


def test_grip_is_checked_where_it_is_known():
    grippy = car(tyres={"friction_coefficient": 0.5})
    assert limit(grippy, cycle_of([0.0, 6.0]), "grip").exceeded
    assert limit(car(), cycle_of([0.0, 6.0]), "grip").limit is None


def test_rows_that_come_faster_than_the_loop_are_said():
    slow = car(controller={"loop_rate_hz": 50})
    assert limit(slow, cycle_of([0.0, 0.1, 0.2], step=0.01), "loop rate").exceeded
