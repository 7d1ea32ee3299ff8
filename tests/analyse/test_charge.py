"""Power from a state of charge, against the power that was put into it."""

import numpy as np
import pytest

from rcc_sim.analyse.charge import STEPS, charge_of
from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import Logged, steered
from rcc_sim.analyse.stale import between_updates, held_rows, refreshed
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.trace import Trace

TWIZY = load_vehicle("twizy")
STEP = 0.02


def drained(power, time):
    """A log whose battery gives this power [W], its charge in steps of 0.02 %."""
    energy = np.concatenate([[0.0], np.cumsum(power[1:] * np.diff(time))])
    charge = 90 - 100 * energy / TWIZY.battery_energy
    rounded = np.round(charge / STEP) * STEP
    speed = np.full(len(time), 8.0)
    columns = {"time_s": time, "speed_mps": speed, "state_of_charge_percent": rounded}
    return Trace(columns, name="drained")


@pytest.mark.parametrize("seed", range(5))
def test_the_power_put_in_comes_out_but_for_rounding(seed):
    rng = np.random.default_rng(seed)
    time = np.arange(3000.0)
    power = 2000 + 1500 * np.sin(time / rng.uniform(40, 300))
    charge = charge_of(drained(power, time), TWIZY)
    error = charge.power - charge.means(power)
    half_steps = 2 * 0.5 * STEP / 100 * TWIZY.battery_energy
    assert np.all(np.abs(error) * np.diff(time[charge.edges]) <= half_steps * 1.0001)
    assert np.std(error) == pytest.approx(np.mean(charge.noise), rel=0.3)
    assert len(charge.power) == pytest.approx(
        np.trapezoid(power) / TWIZY.battery_energy * 100 / STEP / STEPS, rel=0.05
    )


def test_the_sum_over_all_stretches_is_what_the_charge_fell_by():
    time = np.arange(2000.0)
    log = drained(np.full(len(time), 3000.0), time)
    charge = charge_of(log, TWIZY)
    fallen = log["state_of_charge_percent"][charge.edges[[0, -1]]] @ [1, -1]
    drawn = charge.power @ np.diff(time[charge.edges])
    assert drawn == pytest.approx(fallen / 100 * TWIZY.battery_energy)


def test_a_charge_that_jumps_spoils_one_stretch_alone():
    time = np.arange(2000.0)
    log = drained(np.full(len(time), 3000.0), time)
    columns = dict(log.columns)
    columns["state_of_charge_percent"] = columns["state_of_charge_percent"] - 2 * (
        time > 900
    )
    charge = charge_of(Trace(columns, name="jump"), TWIZY)
    (lost,) = np.flatnonzero(np.isnan(charge.power))
    assert charge.edges[lost] < 901 <= charge.edges[lost + 1]
    off = np.abs(charge.power - 3000) * np.diff(time[charge.edges])
    assert np.nanmax(off) <= STEP / 100 * TWIZY.battery_energy * 1.0001


def test_a_hole_in_the_speed_leaves_an_uncertainty():
    """A stretch of the charge may hold rows at which nothing is predicted."""
    time = np.arange(3000.0)
    log = drained(2000 + 1500 * np.sin(time / 90), time)
    log.columns["speed_mps"][:] = 8 + np.sin(time / 50)
    log.columns["speed_mps"][1000:1040] = np.nan
    found = gap(Logged(log, (), None), TWIZY).energy
    assert found.numerical_wh < 0.01 * found.measured_wh
    assert found.u_val > found.tolerance_wh > 0


def test_a_log_with_a_battery_current_needs_no_charge():
    time = np.arange(2000.0)
    log = drained(np.full(len(time), 3000.0), time)
    columns = {**log.columns, "battery_current_a": np.full(len(time), 50.0)}
    assert charge_of(Trace(columns, name="known"), TWIZY) is None
    flat = {**log.columns, "state_of_charge_percent": np.full(len(time), 80.0)}
    assert charge_of(Trace(flat, name="flat"), TWIZY) is None


def wandering(rng, rows=600):
    return 0.5 + np.abs(np.cumsum(rng.normal(0, 0.3, rows)))


def test_a_speed_that_was_held_is_left_out_where_it_repeats():
    rng = np.random.default_rng(2)
    true = wandering(rng)
    fresh = rng.random(len(true)) < 0.4
    fresh[0] = True
    last = np.maximum.accumulate(np.where(fresh, np.arange(len(true)), 0))
    seen = Trace({"time_s": np.arange(600.0), "speed_mps": true[last]}, name="held")
    log, (found,) = refreshed(seen)
    assert np.array_equal(np.isfinite(log["speed_mps"]), fresh)
    assert found.kind == "held"


@pytest.mark.parametrize("every", [2, 4, 10])
def test_channels_of_one_slow_message_are_known_where_it_came(every):
    rng = np.random.default_rng(4)
    came = np.arange(0, 2000, every)
    last = np.repeat(came, every)
    message = {
        "yaw_rate_radps": rng.normal(size=2000),
        "accel_x_mps2": rng.normal(size=2000),
    }
    coarse = np.round(wandering(rng, 2000), 1)
    columns = {name: values[last] for name, values in message.items()}
    columns |= {"time_s": np.arange(2000) / 100, "speed_mps": coarse[last]}
    columns |= {"battery_voltage_v": rng.normal(8, 0.1, 2000), "throttle": coarse[last]}
    log, (found,) = between_updates(Trace(columns, name="slow"), message)
    for name in (*message, "speed_mps"):  # also where the speed came twice the same
        assert np.array_equal(np.flatnonzero(np.isfinite(log[name])), came)
    assert np.isfinite(log["battery_voltage_v"]).all()
    assert np.array_equal(log["throttle"], columns["throttle"])
    assert found.kind == "held"


def test_a_speed_that_comes_seldom_and_stays_is_known_as_often():
    """At a cruise of a minute nothing changes, and the car drives all the same."""
    t = np.arange(0.0, 200.0, 0.1)
    at = [0, 40, 60, 120, 160, 200]
    true = np.interp(t, at, [0, 13, 13, 13, 27, 0]) + 0.3 * np.sin(t) * (t < 40)
    log = Trace({"time_s": t, "speed_mps": true[np.arange(2000) // 10 * 10]}, name="x")
    slow, (found,) = between_updates(log, ["speed_mps"])
    known = np.flatnonzero(np.isfinite(slow["speed_mps"]))
    assert np.array_equal(known, np.arange(0, 2000, 10))
    assert "every 10 rows" in found.what


def test_a_log_without_slow_channels_is_returned_as_it_is():
    rng = np.random.default_rng(5)
    log = Trace({"time_s": np.arange(600.0), "speed_mps": wandering(rng)}, name="live")
    assert between_updates(log, ()) == (log, ())


def test_a_speed_that_is_constant_or_coarse_stays():
    rng = np.random.default_rng(3)
    true = wandering(rng)
    coarse = np.round(np.convolve(true, np.ones(40) / 40, "same") / 0.2) * 0.2
    for speed in (true, coarse, np.full(600, 5.0)):
        assert not held_rows(speed).any()


def test_a_steering_command_is_an_angle_by_the_files_map():
    car = load_vehicle("dart_jetracer")
    command = np.linspace(-1, 1, 21)
    log = Trace({"time_s": np.arange(21.0), "steering": command}, name="steered")
    angle = steered(log, car)["steer_cmd_rad"]
    left, right = command > 0, command < 0
    published = 0.3658 * np.tanh(1.3929 * command)
    assert angle[left] == pytest.approx(published[left], abs=1e-4)
    published = 0.5148 * np.tanh(1.0230 * command)
    assert angle[right] == pytest.approx(published[right], abs=1e-4)
    bad = car.changed(settings={"controller.steering_command": [1.0, 0.0]})
    with pytest.raises(InputError, match="steering_command"):
        steered(log, bad)


def test_a_dead_zone_and_a_plain_map_are_the_published_force():
    car = load_vehicle("dart_jetracer")
    control = car.controller
    threshold = car.effects["throttle_dead_zone"]["threshold"].value
    per_throttle = control.force_n[1][0] / control.force_throttle[1]
    assert per_throttle == 25.358
    assert threshold == 0.1638
    assert per_throttle / control.force_speed_mps[1] == pytest.approx(4.815, rel=1e-4)
