"""A tie is told, a run proposed; driven, it leaves the right effect alone."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.blind import bases, drives, sensors, worth
from rcc_sim.blind.case import logged_columns
from rcc_sim.blind.make import packed
from rcc_sim.blind.nominal import vehicle_text
from rcc_sim.blind.plant import CLOCK
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.deliver import write_next_run
from rcc_sim.diagnose.next_run.menu import STAND
from rcc_sim.diagnose.run import diagnose
from rcc_sim.trace import read_trace
from rcc_sim.units import G

SHARE = 0.25
"""Of the mass: what is on board, or what the rotor adds to it on a straight."""

CAR = replace(bases.BASES[0], J=0.0)
STRAIGHT = 45.0  # s
SLOPE = 0.01

ON_THE_MOTOR = ("payload", "rotor_inertia", "motor_lag", "drivetrain_friction")
IN_THE_WHEELS = ("rolling_resistance", "drivetrain_friction", "iron_loss", "payload")
ON_THE_WAY = ("rolling_resistance", "drivetrain_friction", "iron_loss", "road_grade")


def truth(effect):
    p = bases.truth(CAR, CAR.r_w)
    if effect == "payload":
        return p._replace(m=p.m * (1 + SHARE), I_z=p.I_z * (1 + SHARE))
    return p._replace(J=SHARE * p.m / p.n**2)


def driven(p, speed, steer, path, seed):
    """Drive the plant over commands on its clock; write what its sensors see."""
    how = drives.TIMING["rc"]
    rng = np.random.default_rng(seed)
    dt = how.tick / how.substeps
    per_row = round(how.row / dt)
    rows = np.arange(per_row // 2, round((len(speed) - 1) * CLOCK / dt), per_row)
    rough = drives.rough_road(len(speed), 0.03, 0.5, rng)
    level = np.zeros(2)
    drive = drives.Drive(
        speed, steer, rough, level, 5.0, np.zeros(1), np.zeros(1), rows
    )
    out, _ = worth.fine(p, drive, "rc")
    read = sensors.sensed("rc", out, sensors.constants("rc", rng), rng)
    keep = np.ones(len(rows), bool)
    path.write_bytes(packed(logged_columns("rc", rows * dt, read, keep, drive, True)))
    return path


def commanded(path):
    """Return speed and steering of a file of commands on the plant's clock."""
    commands = read_trace(str(path))
    clock = np.arange(0.0, commands["time_s"][-1], CLOCK)
    return (
        np.interp(clock, commands["time_s"], commands[c])
        for c in ("speed_ref_mps", "steer_cmd_rad")
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("true", "other"),
    [
        pytest.param("payload", "rotor_inertia", marks=pytest.mark.thorough),
        ("rotor_inertia", "payload"),
    ],
)
def test_the_proposed_run_breaks_the_tie_whichever_is_true(true, other, tmp_path):
    (tmp_path / "car.toml").write_text(vehicle_text("car", CAR, ()))
    car, p = load_vehicle(tmp_path / "car.toml"), truth(true)
    speed = drives.speed_programme(CAR, "track", np.random.default_rng(3))
    speed = speed[: round(STRAIGHT / CLOCK)]
    first = driven(p, speed, 0 * speed, tmp_path / "first.csv.gz", 1)
    found = diagnose([open_log(str(first), car)], car, candidates=ON_THE_MOTOR)
    cause = found.asserted[0].cause
    assert {cause.effect, *cause.tied} >= {true, other}
    best = next(e for e in found.experiments if e.run.is_commanded)
    assert best.expected_nats.least > 10.0

    write_next_run(found, tmp_path / "next_run.csv")
    speed, steer = commanded(tmp_path / "next_run.csv")
    second = driven(p, speed, steer, tmp_path / "second.csv.gz", 2)
    logs = [open_log(str(log), car) for log in (first, second)]
    again = diagnose(logs, car, candidates=ON_THE_MOTOR)
    assert [a.cause.effect for a in again.asserted] == [true]
    assert again.asserted[0].cause.tied == ()


@pytest.mark.slow
def test_a_slope_that_drags_alike_is_told_by_driving_out_and_back(tmp_path):
    (tmp_path / "car.toml").write_text(vehicle_text("car", CAR, ()))
    car, p = load_vehicle(tmp_path / "car.toml"), bases.truth(CAR, CAR.r_w)
    unfelt = ("accel_x_mps2", "elevation_m")
    speed = drives.speed_programme(CAR, "track", np.random.default_rng(3))
    speed = speed[: round(STRAIGHT / CLOCK)]
    up, down = (p._replace(slope=SLOPE * way) for way in (1, -1))
    first = driven(up, speed, 0 * speed, tmp_path / "first.csv.gz", 1)
    found = diagnose(
        [open_log(str(first), car, hide=unfelt)], car, candidates=ON_THE_WAY
    )
    cause = found.asserted[0].cause
    assert {cause.effect, *cause.tied} >= {"drivetrain_friction", "road_grade"}

    run = write_next_run(found, tmp_path / "next_run.csv")
    assert run.is_both_ways
    speed, steer = commanded(tmp_path / "next_run.csv")
    out = driven(up, speed, steer, tmp_path / "out.csv.gz", 2)
    back = driven(down, speed, steer, tmp_path / "back.csv.gz", 3)
    logs = [
        open_log(str(log), car, hide=unfelt, back=log is back)
        for log in (first, out, back)
    ]
    again = diagnose(logs, car, candidates=ON_THE_WAY)
    assert [a.cause.effect for a in again.asserted] == ["road_grade"]
    assert again.asserted[0].cause.tied == ()
    assert again.asserted[0].figures["slope"].value == pytest.approx(SLOPE, rel=0.15)


DRAG = 0.02
"""Weight times which the car is held back, by its tyres or in its bearings."""


def dragged(effect):
    p = bases.truth(bases.BASES[0], bases.BASES[0].r_w)
    force = DRAG * p.m * G
    if effect == "rolling_resistance":
        return p._replace(C_rr=p.C_rr + DRAG)
    return p._replace(dry=p.dry + force / p.n)


def off_the_ground(p):
    """What is left of a car whose wheels turn off the ground, a little heavier ones."""
    return p._replace(m=0.04 * p.m, C_rr=0.0, half_rho_A=0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "true",
    [
        "rolling_resistance",
        pytest.param("drivetrain_friction", marks=pytest.mark.thorough),
    ],
)
def test_tyres_and_bearings_are_told_by_wheels_off_the_ground(true, tmp_path):
    (tmp_path / "car.toml").write_text(vehicle_text("car", bases.BASES[0], ()))
    car, p = load_vehicle(tmp_path / "car.toml"), dragged(true)
    speed = drives.speed_programme(bases.BASES[0], "track", np.random.default_rng(3))
    speed = speed[: round(STRAIGHT / CLOCK)]
    first = driven(p, speed, 0 * speed, tmp_path / "first.csv.gz", 1)
    found = diagnose([open_log(str(first), car)], car, candidates=IN_THE_WHEELS)
    cause = found.asserted[0].cause
    assert {cause.effect, *cause.tied} >= {"rolling_resistance", "drivetrain_friction"}
    assert found.experiments[0].run.where == STAND

    leg = found.experiments[0].run.commands
    clock = np.arange(0.0, leg.time[-1], CLOCK)
    speed = np.interp(clock, leg.time, leg.level)
    lifted = off_the_ground(p)
    second = driven(lifted, speed, 0 * speed, tmp_path / "second.csv.gz", 2)
    logs = [open_log(str(first), car), open_log(str(second), car, on_stand=True)]
    again = diagnose(logs, car, candidates=IN_THE_WHEELS)
    assert [a.cause.effect for a in again.asserted] == [true]
    tied = set(again.asserted[0].cause.tied)
    assert tied <= {"iron_loss"}  # its hysteresis is friction, whatever the wheels do
    (figure,) = again.asserted[0].figures.values()
    size = DRAG if true == "rolling_resistance" else dragged(true).dry
    assert figure.value == pytest.approx(size, rel=0.1)
