"""A battery's meter on another clock, and an altimeter out of step, are no causes."""

from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.judge.misread import misread
from rcc_sim.diagnose.residuals.lateness import NEIGHBOURS
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.shapes import late_of
from rcc_sim.report.doubts import misread_sensors
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace, integral_of
from rcc_sim.units import G

CAR = load_vehicle("bmw_i3")
RUN = simulate(CAR, parse_cycle("udds[20:320]"), imposed=True, output_rate=10.0).trace
COLUMNS = ("time_s", "speed_mps", "accel_x_mps2", "motor_torque_nm", "battery_power_w")
NOISE = {
    "speed_mps": 0.005,
    "accel_x_mps2": 0.05,
    "motor_torque_nm": 0.5,
    "battery_power_w": 60.0,
}


def seen(**changed):
    """The drive as sensors see it, some columns changed."""
    rng = np.random.default_rng(5)
    log = {c: RUN[c] for c in COLUMNS} | changed
    noisy = {c: x + rng.normal(0, NOISE.get(c, 0.0), len(x)) for c, x in log.items()}
    return problem_of(Trace(noisy | {"time_s": RUN["time_s"]}, name="log"), CAR)


def tolerances(problem, but=""):
    knobs = [k for k in nuisance_knobs([problem]) if not but or but not in k.key]
    return descent.fit(Engine([problem]), {}, knobs)


def off(fit, key):
    knob = next(k for k in fit.knobs if k.key == key)
    return (fit.values[key] - knob.value) / knob.sd


def test_a_meter_that_averages_the_rows_about_its_own_does_not_change_the_gain():
    """Which taps it has is found; without them its lag is told as an efficiency."""
    taps = {-1: 0.35, 0: 0.4, 1: 0.25}  # before, at and after the row
    power = sum(w * np.roll(RUN["battery_power_w"], -k) for k, w in taps.items())
    problem = seen(battery_power_w=power)
    fit, without = tolerances(problem), tolerances(problem, but="flows_")
    for rows in NEIGHBOURS:
        found = fit.values[f"bias.0.flows_{rows:+d}"]
        assert found == pytest.approx(taps.get(rows, 0.0), abs=0.05)
    scale = "effects.motor_efficiency.scale"
    assert abs(off(fit, scale)) < 1.0
    assert without.score < fit.score - 100


def test_only_a_drive_by_its_torque_has_such_taps():
    assert late_of(seen()).keys() == {f"flows_{k:+d}" for k in NEIGHBOURS}
    bare = {c: RUN[c] for c in COLUMNS if c != "motor_torque_nm"}
    assert not late_of(problem_of(Trace(bare, name="log"), CAR))


def climbs(late=0.0):
    """A hilly road that the car felt, and heights logged so much later. [m]"""
    way = integral_of(RUN["time_s"], RUN["speed_mps"])
    slope = 0.03 * np.sin(way / 150)
    height = integral_of(way, slope)
    logged = np.interp(RUN["time_s"] - late, RUN["time_s"], height)
    weight = CAR.body.mass_kg.value * G
    lever = CAR.tyres.radius_m.value / CAR.drivetrain.gear_ratio.value
    torque = RUN["motor_torque_nm"] + weight * slope * lever
    power = RUN["battery_power_w"] + weight * slope * RUN["speed_mps"]
    felt = RUN["accel_x_mps2"] + G * slope
    return {
        "motor_torque_nm": torque,
        "battery_power_w": power,
        "accel_x_mps2": felt,
        "elevation_m": logged,
    }


def test_heights_of_the_road_are_believed():
    fit = tolerances(seen(**climbs()))
    assert abs(fit.values["bias.0.elevation_m.scale"]) < 0.2
    assert misread(fit) == ()


def test_heights_that_come_late_are_told_and_move_no_figure_of_the_car():
    problem = seen(**climbs(late=20.0))
    fit, without = tolerances(problem), tolerances(problem, but="elevation_m")
    (finding,) = misread(fit)
    assert finding.channel == "elevation_m" and "out of step" in finding.what
    scale = fit.values["bias.0.elevation_m.scale"]
    assert scale > 0.6 and finding.factor == pytest.approx(1 - scale, abs=1e-3)
    shown = SimpleNamespace(gap=SimpleNamespace(findings=(finding,)))
    ((word, text),) = misread_sensors(shown)
    assert word == "DOUBT" and "--hide elevation_m" in text
    assert without.score < fit.score - 100


def test_a_road_is_as_steep_as_it_was_felt():
    problem = seen(**climbs())
    _, slope = problem.drive.road
    for gain in (0.0, 0.25, 1.0):
        _, felt = problem.by_felt_road(gain).drive.road
        assert felt == pytest.approx((1 - gain) * slope)
    # what a share of the slopes does is in proportion to it
    level, whole = problem.by_felt_road(1.0).predict({}), problem.predict({})
    shape = problem.shapes["elevation_m.scale"]
    for c, per_unit in zip(problem.channels, shape.tracks, strict=True):
        off = np.nan_to_num(level[c] - whole[c])
        assert per_unit == pytest.approx(off, abs=0.02 * np.abs(off).max() + 1e-9)


def test_a_torque_that_reads_too_much_is_told():
    """An inverter that says 15 % more than it does, beside a battery and a mass."""
    torque = 1.15 * RUN["motor_torque_nm"]
    fit = tolerances(seen(**climbs() | {"motor_torque_nm": torque}))
    told = [f for f in misread(fit) if f.channel == "motor_torque_nm"]
    scale = fit.values["bias.0.motor_torque_nm.scale"]
    assert scale > 0.09
    (finding,) = told
    assert finding.factor == pytest.approx(1 / (1 + scale), abs=1e-3)
    assert "scale_sd" in finding.action
