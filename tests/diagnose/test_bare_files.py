"""Vehicle files that state little: no battery, or no doubt of any figure."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from tests.analyse.test_gap import SMALL
from tests.cars import car, truck


def logged(trace, names):
    return Logged(Trace({c: trace[c] for c in names}, name="log"), (), None)


@pytest.mark.slow
def test_a_car_whose_battery_is_not_stated_is_diagnosed_by_what_was_logged():
    trace = simulate(car(), SMALL).trace
    noisy = trace["speed_mps"] + np.random.default_rng(2).normal(0, 0.02, len(trace))
    log = Trace({**trace.columns, "speed_mps": noisy})
    names = ("time_s", "speed_ref_mps", "speed_mps", "motor_current_a")
    bare = car(battery__open_circuit_voltage_v=None)
    found = diagnose([logged(log, names)], bare)
    assert (found.status, found.asserted) == ("no_gap", ())


@pytest.mark.slow
def test_a_file_without_an_sd_and_a_log_without_noise_leave_nothing_to_move():
    cycle = parse_cycle("udds[100:200]")
    load = {"auxiliary_load": {"power_w": 500.0}}
    names = ("time_s", "speed_mps", "battery_power_w")
    log = logged(simulate(truck(load), cycle, imposed=True).trace, names)
    assert not diagnose([log], truck(load)).asserted
    found = diagnose([log], truck())
    assert [a.cause.effect for a in found.asserted] == ["auxiliary_load"]
    assert found.asserted[0].figures["power_w"].value == pytest.approx(500.0, rel=0.01)
