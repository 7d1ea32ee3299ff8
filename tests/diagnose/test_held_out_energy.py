"""The energy that proves causes is that of the gap, holes left out of both."""

import numpy as np
import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.gap_energy import percent_of
from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.proof.hold_out import energies, energy_percent
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from rcc_sim.units import J_PER_WH

CAR = load_vehicle("r1t_epa")
COLUMNS = ("time_s", "speed_mps", "battery_power_w")


@pytest.fixture(scope="module")
def log():
    """A drive of which a minute of power is lost, in the midst of a hard pull."""
    run = simulate(CAR, parse_cycle("us06[0:200]"), imposed=True, output_rate=10.0)
    columns = {c: run.trace[c].copy() for c in COLUMNS}
    hardest = int(columns["battery_power_w"].argmax())
    columns["battery_power_w"] *= 1.1
    columns["battery_power_w"][hardest + 1 : hardest + 601] = np.nan
    return Trace(columns, name="holed")


def test_it_is_that_of_the_gap(log):
    whole = gap(Logged(log, (), None), CAR).energy
    problem = problem_of(log, CAR)
    measured, simulated = energies(problem, problem, {})
    assert measured / J_PER_WH == pytest.approx(whole.measured_wh, rel=1e-9)
    assert simulated / J_PER_WH == pytest.approx(whole.simulated_wh, rel=1e-9)
    # what was measured is 1.1 times as much at each row: so is their sum
    assert energy_percent([problem], [({}, None)]) == pytest.approx(100 / 11, rel=2e-3)


@pytest.mark.parametrize(
    ("measured", "simulated", "percent"),
    [(50.0, 45.0, 10.0), (-50.0, -45.0, -10.0), (-50.0, -60.0, 20.0), (0.0, 1.0, None)],
)
def test_a_share_of_energy_given_back_keeps_the_sign_of_the_gap(
    measured, simulated, percent
):
    """A log down a hill gives back: what the model gives back too little is less."""
    assert percent_of(measured, simulated) == percent
