"""Every effect: there, harmless when neutral, felt when not."""

import inspect

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.physics import bicycle, control, powertrain, run, slip, step
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.physics.params import SINKS
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.units import unit_of
from tests.cars import car, truck

CYCLE = Cycle(
    "c", np.array([0.0, 3, 6, 8, 11, 14, 15]), np.array([0, 4, 4, 6, 0.5, 0, 0])
)
FAST = Cycle("f", np.array([0.0, 8, 20, 30, 36]), np.array([0, 15, 15, 5, 0]))
BASE = {
    "rotor_inertia": {"inertia_kgm2": 1e-6},
    "drivetrain_damping": {"damping_nms_per_rad": 1e-5},
    "rolling_resistance": {"coefficient": 0.02},
    "aerodynamic_drag": {"drag_area_m2": 0.05},
}
OFF_NEUTRAL = {
    "aerodynamic_drag": {"drag_area_m2": 0.3},
    "auxiliary_load": {"power_w": 4.0},
    "battery_resistance": {"resistance_ohm": 0.05},
    "copper_loss": {"phase_resistance_ohm": 0.02},
    "current_limit": {"max_current_a": 10.0},
    "drivetrain_damping": {"damping_nms_per_rad": 3e-5},
    "drivetrain_friction": {"torque_nm": 0.002},
    "gear_loss": {"efficiency": 0.9},
    "headwind": {"speed_mps": 2.0},
    "iron_loss": {"hysteresis_torque_nm": 0.001, "eddy_nms_per_rad": 1e-6},
    "motor_efficiency": {"scale": 0.8},
    "payload": {"mass_kg": 0.5},
    "reference_sampling": {"period_s": 0.2},
    "auxiliary_gain": {"gain": 1.2},
    "regeneration_limit": {"max_current_a": 1.0},
    "regeneration_fade": {"fade_speed_mps": 1.5},
    "friction_brake": {"share": 0.3},
    "road_grade": {"slope": 0.02},
    "rolling_resistance": {"coefficient": 0.04},
    "rotor_inertia": {"inertia_kgm2": 5e-6},
    "speed_dead_zone": {"threshold_radps": 60.0},
    "tyre_saturation": {"friction_coefficient": 0.7},
    "wheel_radius": {"scale": 1.03},
    "front_cornering_stiffness": {"scale": 0.8},
    "rear_cornering_stiffness": {"scale": 1.2},
    "cg_shift": {"shift_m": 0.02},
    "yaw_inertia": {"scale": 1.2},
    "speed_loop": {"proportional_scale": 0.6, "integral_scale": 1.5},
    "steering_gain": {"gain": 0.9},
    "steering_offset": {"angle_rad": 0.02},
    "steering_lag": {"time_constant_s": 0.1},
    "steering_delay": {"delay_s": 0.0505},
    "steering_backlash": {"width_rad": 0.01},
    "steering_drag": {"force_n_per_rad": 4.0},
    "actuation_delay": {"delay_s": 0.0203},
    "reference_delay": {"delay_s": 0.0505},
    "motor_lag": {"time_constant_s": 0.05},
    "tyre_relaxation": {"length_m": 0.1},
    "speed_sensor_scale": {"scale": 1.02},
    "current_sensor_scale": {"scale": 0.97},
    "yaw_rate_bias": {"bias_radps": 0.01},
    "accelerometer_bias": {"x_mps2": 0.2, "y_mps2": -0.1},
    "longitudinal_slip": {"stiffness_n": 300.0},
    "sensor_delay": {"delay_s": 0.03, "battery_delay_s": 0.0123},
}


def same(one, other):
    return one.trace.columns.keys() == other.trace.columns.keys() and all(
        np.array_equal(one.trace[c], other.trace[c]) for c in one.trace.columns
    )


@pytest.mark.parametrize("name", EFFECTS)
@pytest.mark.parametrize("imposed", [False, True])
def test_an_effect_at_neutral_leaves_the_trace_bit_identical(name, imposed):
    base = {k: v for k, v in BASE.items() if k != name}
    if name == "headwind":
        base = BASE
    if EFFECTS[name].excludes:
        base = {k: v for k, v in base.items() if k not in EFFECTS[name].excludes}
    lanes = LaneChanges(8.0)
    without = simulate(car(base), CYCLE, imposed=imposed, lanes=lanes)
    neutral = car(base | {name: EFFECTS[name].neutral})
    assert same(without, simulate(neutral, CYCLE, imposed=imposed, lanes=lanes))


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_off_neutral_moves_the_trace(name):
    if "throttle" in EFFECTS[name].shows_in:
        pytest.skip("acts on a throttle: see test_throttle.py")
    if name == "road_load":
        base, params = {}, {"a_n": 1.0, "b_n_s_per_m": 0.1, "c_n_s2_per_m2": 0.01}
    else:
        base, params = dict(BASE), OFF_NEUTRAL[name]
    how = {"lanes": LaneChanges(8.0)}
    if "metered" in EFFECTS[name].shows_in:
        how["aux_power"] = ([0.0, 15.0], [20.0, 10.0])
    before = simulate(car(base), CYCLE, **how)
    after = simulate(car(base | {name: params}), CYCLE, **how)
    assert not same(before, after)
    sink = EFFECTS[name].sink
    assert not sink or np.abs(after.trace[f"energy_{sink}_j"]).max() > 0


@pytest.mark.parametrize("name", [n for n, e in EFFECTS.items() if e.sensor])
def test_a_sensor_effect_leaves_the_energy_to_the_car(name):
    lanes = LaneChanges(8.0)
    true = simulate(car(BASE), CYCLE, lanes=lanes)
    seen = simulate(car(BASE | {name: OFF_NEUTRAL[name]}), CYCLE, lanes=lanes)
    assert seen.ledger == true.ledger
    for column in EFFECTS[name].channels:
        assert not np.array_equal(seen.trace[column], true.trace[column])
    assert np.array_equal(seen.trace["x_m"], true.trace["x_m"])


@pytest.mark.parametrize("name", [n for n, e in EFFECTS.items() if not e.sensor])
def test_an_effect_has_its_call_in_the_kernel(name):
    module = f"rcc_sim.physics.effects.{name}"
    kernel = [
        f.__code__
        for m in (step, run, control, powertrain, bicycle, slip)
        for f in vars(m).values()
        if inspect.isfunction(f) and f.__module__ == m.__name__
    ]
    used = {n for code in kernel for n in code.co_names}
    own = {
        f.__name__
        for m in (step, run, control, powertrain, bicycle, slip)
        for f in vars(m).values()
        if getattr(f, "__module__", "") == module
    }
    assert own & used, f"{name} is imported nowhere or called nowhere"


def test_sinks_belong_to_one_effect_each():
    assert len(set(SINKS)) == len(SINKS)


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=lambda e: e.id)
def test_an_effect_says_all_that_a_user_needs(effect):
    assert effect.title and effect.equation and effect.seen_as and effect.source
    assert effect.channels
    for param in effect.params:
        low, high = param.bounds
        assert low <= param.neutral <= high
        assert low <= param.typical[0] <= param.typical[1] <= high
        dimensionless = {"coefficient", "efficiency", "scale", "slope", "gain"}
        dimensionless |= {"threshold", "share"}
        named = param.name.rpartition("_")[2] if "_" in param.name else param.name
        assert unit_of(param.name) != "1" or named in dimensionless


def test_regeneration_limited_leaves_the_rest_to_the_brakes():
    free = simulate(truck(BASE), FAST)
    limit = {"regeneration_limit": {"max_torque_nm": 50.0}}
    limited = simulate(truck(BASE | limit), FAST)
    assert "brakes" not in free.ledger
    assert limited.ledger["brakes"] > 0
    assert limited.trace["motor_torque_nm"].min() == pytest.approx(-50.0)


def test_current_limit_caps_the_current_and_the_speed_falls_behind():
    limit = {"current_limit": {"max_current_a": 5.0}}
    run_ = simulate(car(BASE | limit), CYCLE)
    assert run_.trace["motor_current_a"].max() == pytest.approx(5.0)
    gap = run_.trace["speed_ref_mps"] - run_.trace["speed_mps"]
    assert gap.max() > 0.3


def test_the_reference_is_held_between_samples():
    run_ = simulate(car(BASE | {"reference_sampling": {"period_s": 0.5}}), CYCLE)
    t, v = run_.trace["time_s"], run_.trace["speed_ref_mps"]
    changes = t[1:][np.diff(v) != 0]
    assert np.allclose(changes / 0.5, np.round(changes / 0.5), atol=0.05)


def test_a_dead_zone_makes_a_current_spike_at_launch():
    smooth = simulate(car(BASE), CYCLE)
    spiky = simulate(car(BASE | {"speed_dead_zone": {"threshold_radps": 100.0}}), CYCLE)
    launch = smooth.trace["time_s"] < 1.0
    top = lambda r: r.trace["motor_current_a"][: launch.sum()].max()  # noqa: E731
    assert top(spiky) > 2 * top(smooth)


def test_a_wheel_larger_than_the_file_says_drives_further_than_the_log():
    run_ = simulate(car(BASE | {"wheel_radius": {"scale": 1.05}}), CYCLE)
    seen = np.trapezoid(run_.trace["speed_mps"], run_.trace["time_s"])
    assert run_.trace["distance_m"][-1] == pytest.approx(1.05 * seen, rel=1e-3)
