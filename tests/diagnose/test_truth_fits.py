"""The model that made a log reproduces it as the diagnosis runs it, whatever acts."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace

T = np.array([0.0, 2, 6, 9, 12, 15, 18])
CYCLE = Cycle("c", T, np.array([0.0, 0, 4, 4, 2, 5, 1]))
ACTING = {
    "wheel_radius.scale": 0.95,
    "speed_sensor_scale.scale": 1.05,
    "current_sensor_scale.scale": 1.08,
    "sensor_delay.yaw_rate_delay_s": 0.03,
    "sensor_delay.accel_delay_s": 0.03,
    "accelerometer_bias.x_mps2": 0.4,
    "yaw_rate_bias.bias_radps": 0.02,
    "payload.mass_kg": 0.4,
    "road_grade.slope": 0.02,
    "rolling_resistance.coefficient": 0.02,
    "drivetrain_friction.torque_nm": 0.004,
    "gear_loss.efficiency": 0.9,
    "auxiliary_load.power_w": 8.0,
    "motor_lag.time_constant_s": 0.03,
    "current_limit.max_current_a": 12.0,
    "speed_loop.proportional_scale": 0.6,
    "steering_lag.time_constant_s": 0.06,
    "steering_delay.delay_s": 0.04,
    "steering_gain.gain": 1.1,
    "steering_offset.angle_rad": 0.02,
    "yaw_inertia.scale": 1.2,
    "tyre_relaxation.length_m": 0.05,
}
LOGGED = (
    *("time_s", "speed_ref_mps", "steer_cmd_rad", "speed_mps", "yaw_rate_radps"),
    *("accel_x_mps2", "accel_y_mps2", "motor_current_a", "battery_current_a"),
    *("battery_voltage_v", "battery_energy_j"),
)
MOST = 0.003
"""Root mean square of what is left, in standard deviations of a channel. [1]"""


@pytest.mark.parametrize("figure", ACTING)
def test_what_made_a_log_is_drawn_away_from_none_of_its_channels(figure):
    car = load_vehicle("rcc")
    true = car.changed(settings={f"effects.{figure}": ACTING[figure]})
    lanes = LaneChanges(12.0, 0.3, 8.0)
    run = simulate(true, CYCLE, output_rate=200.0, lanes=lanes).trace
    log = Trace({name: run[name] for name in LOGGED}, name="log")
    problem = problem_of(log, true)
    assert len(problem.channels) == 6
    for channel, left in zip(problem.channels, problem.residuals({}), strict=True):
        seen = problem.known(channel)
        size = float(np.nanstd(problem.log[channel][seen]))
        assert float(np.sqrt(np.nanmean(left[seen] ** 2))) < MOST * size, channel


@pytest.mark.parametrize("delay", [0.02, 0.07, 0.1, 0.13, 0.25])
def test_a_speed_that_is_late_by_no_whole_rows_draws_its_car_nowhere(delay):
    """At 10 Hz, on a clock that jitters as a car's computer does."""
    late = {"effects.sensor_delay.speed_delay_s": {"value": delay}}
    car = load_vehicle("dart_jetracer").changed(settings=late)
    rng = np.random.default_rng(1)
    t = np.cumsum(np.r_[0.0, 0.1 + 0.002 * rng.standard_normal(99)])
    throttle = 0.35 * ((t > 1) & (t < 3)) + 0.45 * ((t > 5) & (t < 8))
    commands = {"time_s": t, "throttle": throttle, "steer_cmd_rad": 0 * t}
    out = replay(car, drive_of(Trace(commands), car))
    log = Trace(commands | {"speed_mps": out["speed_mps"]}, name="log")
    problem = problem_of(log, car)
    (left,) = problem.residuals({})
    assert np.sqrt(np.nanmean(left**2)) < MOST * np.std(log["speed_mps"])
