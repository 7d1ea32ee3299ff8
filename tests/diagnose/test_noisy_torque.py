"""A torque that was logged drives the model without its noise, and with its steps."""

import numpy as np
import pytest

from rcc_sim.analyse.gap_stages import untorqued
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.residuals.posed import calmed, problem_of
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

CAR = load_vehicle("r1t_epa")
RUN = simulate(CAR, parse_cycle("hwfet[0:400]"), imposed=True, output_rate=10.0).trace
TRUE = RUN["motor_torque_nm"]
COLUMNS = {c: RUN[c] for c in ("time_s", "speed_mps", "battery_power_w")}
WIND = 25.0 * np.sin(RUN["time_s"] / 20)  # N m that no motion tells


def problem(noise, lost=0):
    torque = TRUE + WIND + np.random.default_rng(4).normal(0, noise, len(TRUE))
    torque[:lost] = np.nan
    log = Trace(COLUMNS | {"motor_torque_nm": torque}, name="log")
    return Problem(CAR, log, drive_of(log, CAR, np.inf))


def off(problem):
    return float(np.nanstd(problem.drive.measured.torque - TRUE - WIND))


def test_its_noise_goes_and_what_the_motion_does_not_tell_stays():
    rough = problem(8.0)
    assert off(rough) == pytest.approx(8.0, rel=0.05)
    assert off(calmed(rough)) < 0.4 * 8.0


def test_a_torque_without_noise_stays_as_it_is():
    clean = problem(0.0)
    np.testing.assert_allclose(
        calmed(clean).drive.measured.torque, clean.drive.measured.torque, atol=1e-6
    )


def test_rows_without_a_torque_stay_without():
    known = np.isfinite(calmed(problem(8.0, lost=50)).drive.measured.torque)
    assert not known[:50].any() and known[50:].all()


def test_what_is_compared_is_what_was_logged():
    rough = problem(8.0).log
    posed = problem_of(rough, CAR)
    np.testing.assert_array_equal(
        posed.log["motor_torque_nm"], rough["motor_torque_nm"]
    )
    still = untorqued(posed.drive)
    assert calmed(Problem(CAR, rough, still)).drive is still


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_gusts_that_are_less_than_the_noise_are_not_smoothed_away(seed):
    """Of 6 s and 0.6 of the noise; the share that is left, by least squares."""
    gusts = 0.6 * 2**0.5 * 8.0 * np.sin(2 * np.pi * RUN["time_s"] / 6.0)
    noise = np.random.default_rng(seed).normal(0, 8.0, len(TRUE))
    log = Trace(COLUMNS | {"motor_torque_nm": TRUE + gusts + noise}, name="log")
    drive = drive_of(log, CAR, np.inf)
    calm = calmed(Problem(CAR, log, drive)).drive.measured.torque
    assert np.std(calm - TRUE - gusts) < 0.8 * 8.0
    assert gusts @ (calm - TRUE) / (gusts @ gusts) > 0.9
