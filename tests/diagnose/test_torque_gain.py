"""A torque that an inverter tells 2 % too large, in a drive by its commands."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

CAR, TRUCK = load_vehicle("rcc"), load_vehicle("r1t")
CYCLE = scale_cycle(parse_cycle("udds[20:420]"), to=CAR, of=TRUCK, rate=40.0).cycle
RUN = simulate(CAR, CYCLE, output_rate=40.0).trace
NOISE = {
    "time_s": 0.0,
    "speed_ref_mps": 0.0,
    "speed_mps": 0.005,
    "motor_torque_nm": 0.001,
    "battery_voltage_v": 0.02,
    "battery_current_a": 0.1,
}


def tolerances(gain, but=""):
    rng = np.random.default_rng(2)
    log = {c: RUN[c] + rng.normal(0, sd, len(RUN)) for c, sd in NOISE.items()}
    log["speed_mps"] = np.abs(log["speed_mps"])
    log["motor_torque_nm"] *= gain
    problem = problem_of(Trace(log, name="log"), CAR)
    assert not problem.drive.imposed and "motor_torque_nm" in problem.channels
    knobs = [k for k in nuisance_knobs([problem]) if not but or but not in k.key]
    return descent.fit(Engine([problem]), {}, knobs)


@pytest.mark.parametrize("gain", [0.98, 1.02])
def test_its_gain_is_found_and_no_figure_of_the_car_moves(gain):
    fit = tolerances(gain)
    found = fit.values["bias.0.motor_torque_nm.scale"]
    assert found == pytest.approx(gain - 1, abs=0.005)
    pulls = {k.key: (fit.values[k.key] - k.value) / k.sd for k in fit.knobs}
    assert max(abs(x) for key, x in pulls.items() if "bias" not in key) < 1.5
    without = tolerances(gain, but="motor_torque_nm")
    assert fit.score > without.score + 20  # worth a cause
