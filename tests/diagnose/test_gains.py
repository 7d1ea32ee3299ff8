"""A torque, or a gyro, that reads a few per cent too much blames nobody."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged, open_log
from rcc_sim.blind.make import make
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.sensors import SCALES
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob, bias_knobs, scale_key
from rcc_sim.diagnose.judge.misread import gains
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

CAR = load_vehicle("tesla_model_3")
NOISE = {"speed_mps": 0.02, "motor_torque_nm": 1.0,
         "battery_voltage_v": 0.3, "battery_current_a": 0.5}  # fmt: skip


def drive(car=CAR, gain: float = 1.0, share: float = 1.0) -> Trace:
    """A town drive at 10 Hz whose torque reads some times the true one; speed, too."""
    cycle = parse_cycle("udds[0:400]")
    run = simulate(car, cycle, imposed=True, output_rate=10).trace
    rng = np.random.default_rng(5)
    scale = {"motor_torque_nm": gain, "speed_mps": share}
    log = {
        c: scale.get(c, 1.0) * run[c] + rng.normal(0, sd, len(run))
        for c, sd in NOISE.items()
    }
    log["speed_mps"] = np.maximum(log["speed_mps"], 0.0)
    return Trace({"time_s": run["time_s"], **log}, name="drive")


def told(log: Trace) -> dict:
    return diagnose([Logged(log, (), None)], CAR).document()


@pytest.mark.parametrize("gain", [0.97, pytest.param(1.03, marks=pytest.mark.thorough)])
def test_a_torque_that_is_a_little_off_is_no_cause(gain):
    assert told(drive(gain=gain))["causes"] == []


def test_a_true_speed_beside_another_tyre_is_no_cause():
    """The motor turns faster than the file's radius makes of the speed."""
    smaller = CAR.changed(settings={"tyres.radius_m": CAR.tyres.radius_m.value * 0.985})
    assert told(drive(smaller))["causes"] == []


def test_a_current_that_is_off_is_found_beside_it():
    log = drive()
    log.columns["battery_current_a"] *= 1.12
    (cause,) = told(log)["causes"]
    assert "current_sensor_scale" in {cause["effect"], *cause["indistinguishable_from"]}


def test_the_gain_is_what_the_file_states():
    exact = CAR.changed(settings={"sensors.motor_torque_nm.scale_sd": 0.002})
    problems = problem_of(drive(), CAR), problem_of(drive(), exact)
    key = scale_key(0, "motor_torque_nm")
    sds = [{k.key: k.sd for k in bias_knobs(p)}[key] for p in problems]
    assert sds == [SCALES["motor_torque_nm"], 0.002]


def test_the_energy_left_is_by_the_torque_as_it_reads():
    key = "effects.auxiliary_load.power_w"
    heated = CAR.changed(settings={key: CAR.figures()[key].value + 1500.0})
    found = told(drive(heated, gain=1.04))
    assert [c["effect"] for c in found["causes"]] == ["auxiliary_load"]
    shrink = found["shrink"]
    assert shrink["energy_by_measured_torque"]
    assert abs(shrink["energy_gap_percent_after"]) < 1.0


@pytest.mark.slow
def test_a_gyro_that_is_a_little_off_blames_no_steering(tmp_path):
    """A drive of the blind plant; where the file calls the gyro exact, something is."""
    make(tmp_path / "seen", cases=1, kinds=("null",), families=("rc",), seed=21)
    for folder in sorted(p for p in (tmp_path / "seen").iterdir() if p.is_dir()):
        car = load_vehicle(folder / "vehicle.toml")
        opened = open_log(folder / "log.csv.gz", car)
        opened.log.columns["yaw_rate_radps"] *= 1.02
        assert diagnose([opened], car).asserted == ()
        exact = car.changed(settings={"sensors.yaw_rate_radps.scale_sd": 0.0005})
        assert diagnose([opened], exact).asserted != ()


@pytest.mark.parametrize("column", ["yaw_rate_radps", "battery_power_w"])
def test_what_is_left_in_bends_makes_a_gain_doubtful_of_what_shows_them(column):
    knob = Knob(scale_key(0, column), 0.0, 0.01)
    fit = Fit({knob.key: 0.05}, (knob,), 0.0, 0.0, [], [])
    (plain,), (beside,) = (gains(fit, bends=bends) for bends in (False, True))
    assert plain.what == beside.what and "seem so" not in plain.action
    assert ("seem so" in beside.action) == (column == "yaw_rate_radps")
