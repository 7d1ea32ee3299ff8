"""A log whose wheels turn off the ground: no road acts, and they alone are moved."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import WHEELS, replay
from rcc_sim.trace import Trace

ACCEL, J, B, DRY = 0.5, 3e-6, 1.2e-5, 0.004  # m/s², kg m², N m s/rad, N m
ROAD = {
    "effects.road_grade.slope": 0.02,
    "effects.headwind.speed_mps": 3.0,
    "effects.rolling_resistance.coefficient": 0.02,
    "effects.aerodynamic_drag.drag_area_m2": 0.03,
}
SHAFT = {
    "effects.drivetrain_damping.damping_nms_per_rad": B,
    "effects.drivetrain_friction.torque_nm": DRY,
    "effects.rotor_inertia.inertia_kgm2": J,
}


def car():
    free = load_vehicle("rcc")
    free = free.changed(without=tuple(free.effects))
    return free.changed(settings=ROAD | SHAFT)


def log(on_stand=None):
    """The wheels speed up evenly."""
    t = np.arange(0.0, 6.0, 0.01)
    columns = {"time_s": t, "speed_mps": ACCEL * t}
    if on_stand is not None:
        columns["on_stand"] = np.broadcast_to(np.asarray(on_stand, float), len(t))
    return Trace(columns, name="log.csv")


def test_the_torque_is_that_of_shaft_and_wheels():
    """τ = B ω + τ_dry + (J + 0.03 m (r/N)²) dω/dt, whatever the road."""
    vehicle = car()
    torque = replay(vehicle, drive_of(log(1), vehicle))["motor_torque_nm"]
    n = vehicle.drivetrain.gear_ratio.value / vehicle.tyres.radius_m.value
    at = 400
    omega = n * ACCEL * (log()["time_s"][at] - 0.005)  # a mean over the row before
    inertia = J + WHEELS * vehicle.body.mass_kg.value / n**2
    assert torque[at] == pytest.approx(B * omega + DRY + inertia * n * ACCEL, rel=1e-6)
    assert (
        torque[at]
        < 0.7 * replay(vehicle, drive_of(log(0), vehicle))["motor_torque_nm"][at]
    )


@pytest.mark.parametrize("drives", ["speed_mps", "speed_ref_mps"])
def test_wheels_that_steer_in_the_air_turn_nothing(drives):
    vehicle, straight = car(), log(1)
    columns = dict(straight.columns) | {drives: straight["speed_mps"]}
    steer = {"steer_cmd_rad": 0.3 * np.sin(straight["time_s"])}
    one, other = (
        replay(vehicle, drive_of(Trace(columns | more), vehicle))["motor_torque_nm"]
        for more in ({}, steer)
    )
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("drives", ["speed_mps", "speed_ref_mps"])
def test_nor_do_wheels_that_stand_askew(drives):
    """It yawed on its stand: a spin seemed to tell all from any steering's offset."""
    straight = log(1)
    columns = Trace(dict(straight.columns) | {drives: straight["speed_mps"]})
    askew = car().changed(effects={"steering_offset": {"angle_rad": -0.03}})
    one, other = (replay(v, drive_of(columns, v)) for v in (car(), askew))
    assert not other["yaw_rate_radps"].any()
    np.testing.assert_array_equal(one["motor_torque_nm"], other["motor_torque_nm"])


def test_heavier_wheels_take_more():
    vehicle = car()
    drive = drive_of(log(1), vehicle)
    once, twice = (
        replay(vehicle, drive, wheels=x)["motor_torque_nm"][400] for x in (1, 2)
    )
    n = vehicle.drivetrain.gear_ratio.value / vehicle.tyres.radius_m.value
    more = WHEELS * vehicle.body.mass_kg.value / n * ACCEL
    assert twice - once == pytest.approx(more, rel=1e-6)


def test_a_road_load_that_is_one_whole_is_refused():
    vehicle = load_vehicle("r1t_epa")
    with pytest.raises(InputError, match=r"effects\.road_load"):
        replay(vehicle, drive_of(log(1), vehicle))


@pytest.mark.parametrize(
    ("values", "told"),
    [(2.0, "row 1: on_stand: 2"), (np.arange(600) > 300, "row 302: on_stand changes")],
)
def test_what_is_neither_road_nor_stand_is_refused(values, told):
    with pytest.raises(InputError, match=told):
        drive_of(log(values), car())


def test_what_a_car_that_stands_still_feels_is_left_out(tmp_path):
    path, t = tmp_path / "spin.csv", np.arange(0.0, 6.0, 0.01)
    felt = np.random.default_rng(0).normal(0, 0.1, len(t))
    columns = {"time_s": t, "speed_mps": ACCEL * t, "accel_x_mps2": felt}
    columns |= {"steer_cmd_rad": 0.1 * np.sin(t), "yaw_rate_radps": felt}
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="")
    kept = open_log(path, car(), on_stand=True).log
    assert set(kept.columns) == {"time_s", "speed_mps", "on_stand"}


def test_what_the_wheels_alone_take_is_no_wrong_unit(tmp_path):
    """Torque and power off the ground are a tenth of what the car's mass asks for."""
    pick_up = load_vehicle("r1t")
    t = np.arange(0.0, 120.0, 0.1)
    v = 8.0 + 4.0 * np.sin(t / 3.0) + 2.0 * np.sin(t / 1.1)
    m, r = 0.1 * pick_up.body.mass_kg.value, pick_up.tyres.radius_m.value
    n = pick_up.drivetrain.gear_ratio.value / r
    torque = m * np.gradient(v, t) / n + 2.0
    power = torque * n * v + 500.0
    path = tmp_path / "stand.csv"
    table = np.column_stack([t, v, torque, power])
    head = "time_s,speed_mps,motor_torque_nm,battery_power_w"
    np.savetxt(path, table, delimiter=",", header=head, comments="", fmt="%.6g")

    def blamed(**how):
        findings = open_log(path, pick_up, **how).findings
        return [f.what for f in findings if "mass times" in f.what]

    assert blamed(on_stand=True) == []
    try:
        road = blamed()
    except InputError as error:
        road = [str(error)]
    assert any("mass times" in what for what in road)


def test_a_column_that_says_so_is_known(tmp_path):
    path = tmp_path / "stand.csv"
    t = np.arange(0.0, 20.0, 0.1)
    table = np.column_stack([t, 3 + np.sin(t), np.ones_like(t), np.ones_like(t)])
    head = "time_s,speed_mps,on_stand,direction"
    np.savetxt(path, table, delimiter=",", header=head, comments="", fmt="%.6g")
    findings = open_log(path, load_vehicle("r1t")).findings
    assert not [f for f in findings if f.kind == "unknown"]
