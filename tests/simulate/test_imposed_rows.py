"""An imposed run at more rows than its cycle has."""

from __future__ import annotations

import numpy as np
import pytest

from rcc_sim.analyse.energy import energy_report
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.simulate.run import simulate

CYCLE = parse_cycle("udds[0:300]")


@pytest.mark.parametrize("name", ["bmw_i3", "r1t"])
def test_more_rows_are_the_same_drive(name):
    car = load_vehicle(name)
    yaw = 0.02 * np.sin(CYCLE.time_s / 20)
    own = simulate(car, CYCLE, imposed=True, yaw_rate=yaw).trace
    fine = simulate(car, CYCLE, imposed=True, yaw_rate=yaw, output_rate=10).trace
    assert np.diff(fine["time_s"]) == pytest.approx(0.1)
    for column in ("speed_mps", "yaw_rate_radps"):
        assert fine[column][::10] == pytest.approx(own[column], abs=1e-9)
    energy = [energy_report(t).energy_wh for t in (own, fine)]
    assert energy[1] == pytest.approx(energy[0], rel=2e-3)
    for sink in (c for c in own.columns if c.startswith("energy_")):
        assert fine[sink][-1] == pytest.approx(own[sink][-1], abs=7.2 * energy[0])


def test_a_rate_that_ends_between_rows_keeps_the_end():
    car = load_vehicle("bmw_i3")
    fine = simulate(car, CYCLE, imposed=True, output_rate=1.7).trace
    assert fine["time_s"][-1] == 300.0
    assert fine["speed_mps"][-1] == pytest.approx(CYCLE.speed_mps[-1])


@pytest.mark.parametrize("rate", [0.5, 0.0, float("nan")])
def test_fewer_rows_are_refused(rate):
    with pytest.raises(InputError, match="output rate"):
        simulate(load_vehicle("bmw_i3"), CYCLE, imposed=True, output_rate=rate)
