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
from rcc_sim.diagnose.run import diagnose
from rcc_sim.report.screen import screen
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace
from rcc_sim.units import J_PER_WH
from tests import scaled_drive

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
    measured, simulated = energies(problem, {})
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


def test_the_offset_of_a_meter_is_no_doubt_of_a_cause_beside_it(tmp_path):
    """A current that reads 1.7 of its stated sds too little: a sixth of the energy."""
    car = load_vehicle("rcc").changed(
        settings={"sensors.battery_current_a.bias_sd": 0.12}
    )
    true = car.changed(settings={"effects.steering_backlash.width_rad": 0.03})
    run = scaled_drive.drive(true, LaneChanges(10.0))
    read = {"battery_current_a": run["battery_current_a"] - 0.2}
    shown = scaled_drive.logged({**run.columns, **read}, car, 3, tmp_path)
    found = diagnose([shown], car)
    (cause,) = found.asserted
    assert cause.cause.effect == "steering_backlash" and cause.probability > 0.9
    assert cause.figures["width_rad"].value == pytest.approx(0.03, rel=0.03)
    assert found.status == "explained"
    assert abs(found.proof.before) > 15.0 > 1.5 > abs(found.proof.after)
    # its volts times what it reads too little, for as long as the drive takes
    time, volts = shown.log["time_s"], shown.log["battery_voltage_v"]
    taken = -0.2 * np.trapezoid(volts, time) / J_PER_WH
    assert found.prices.meters_wh == pytest.approx(taken, rel=0.05)
    assert "more of it by offsets of the meters" in "\n".join(screen(found, 200))
