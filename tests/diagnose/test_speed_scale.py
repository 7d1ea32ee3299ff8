"""A speed that reads too much, or tyres of another size, beside an accelerometer."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.candidates import candidates_for
from rcc_sim.diagnose.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

CAR = load_vehicle("tesla_model_3")
NOISE = {"speed_mps": 0.02, "accel_x_mps2": 0.05, "motor_torque_nm": 1.0,
         "battery_voltage_v": 0.3, "battery_current_a": 0.5}  # fmt: skip
OFF = 1.06


def drive(car, *, reads=1.0, without=()):
    """A town drive at 10 Hz, of a car whose speed reads some times the true one."""
    cycle = parse_cycle("udds[0:400]")
    run = simulate(car, cycle, imposed=True, output_rate=10).trace
    rng = np.random.default_rng(6)
    log = {
        c: run[c] * (reads if c == "speed_mps" else 1.0) + rng.normal(0, sd, len(run))
        for c, sd in NOISE.items()
        if c not in without
    }
    log["speed_mps"] = np.maximum(log["speed_mps"], 0.0)
    return Trace({"time_s": run["time_s"], **log}, name="drive")


def named(log):
    """The effects of the first cause and what ties with it, and its document."""
    causes = diagnose([Logged(log, (), None)], CAR).document()["causes"]
    first = causes[0] if causes else {"effect": "", "indistinguishable_from": []}
    return {first["effect"], *first["indistinguishable_from"]}, causes


def test_a_speed_that_reads_too_much_is_told_from_currents_that_read_too_little():
    effects, causes = named(drive(CAR, reads=OFF))
    assert "speed_sensor_scale" in effects
    figures = {c["effect"]: c["parameters"] for c in causes}
    if "speed_sensor_scale" in figures:
        found = figures["speed_sensor_scale"]["scale"]["value"]
        assert found == pytest.approx(OFF, abs=0.02)


def test_what_nothing_gauges_is_no_candidate():
    for without, there in (((), True), (("accel_x_mps2",), False)):
        problem = problem_of(drive(CAR, without=without), CAR)
        able = {c.effect for c in candidates_for([problem])}
        assert ("speed_sensor_scale" in able) == ("wheel_radius" in able) == there
