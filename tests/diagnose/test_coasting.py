"""A model drawn to its log as hard in a coast as its loop would hold it in a drive."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.replay import RECALLS
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from rcc_sim.units import G
from tests.cars import car

LOSSES = {
    "drivetrain_damping": {"damping_nms_per_rad": 1.2e-5},
    "rotor_inertia": {"inertia_kgm2": 2.2e-6},
    "regeneration_limit": {"max_current_a": 0.0},
}
SEEN = ("time_s", "speed_ref_mps", "speed_mps", "motor_current_a", "battery_current_a")


def left_by(cycle, slope, figures=None):
    """Speed that a log on such a road has beside the model on a level one. [m/s]

    The model's figures being changed so.
    """
    vehicle = car(LOSSES)
    run = simulate(vehicle, cycle, slope=slope, output_rate=100.0).trace
    log = Trace({n: run[n] for n in SEEN}, name="log")
    predicted = problem_of(log, vehicle).driven(figures or {}, RECALLS)
    return run, vehicle, run["speed_mps"] - predicted["speed_mps"]


COAST = Cycle("coast", np.array([0, 2, 4, 7, 8.0]), np.array([0, 5, 5, 0.6, 0.6]))
RISE = 0.01
ROAD = ([0.0, 1.0], [RISE, RISE])


def in_coast(run):
    """Rows of such a drive in which nothing holds the speed."""
    t = run["time_s"]
    return (t > 5.5) & (t < 6.5)


def test_a_force_in_a_coast_moves_it_by_what_loop_and_recall_leave():
    """v = F / (M / T + K_p K_t n²), M being the mass with what turns."""
    run, vehicle, left = left_by(COAST, ROAD)
    coasts = in_coast(run)
    assert not run["motor_current_a"][coasts].any() and run["speed_mps"][coasts].all()
    n = vehicle.drivetrain.gear_ratio.value / vehicle.tyres.radius_m.value
    K_t = 1.5 * vehicle.motor.poles / 2 * vehicle.motor.flux_linkage_wb.value
    K_p = vehicle.controller.proportional_gain_as_per_rad.value
    m = vehicle.body.mass_kg.value
    M = m + LOSSES["rotor_inertia"]["inertia_kgm2"] * n**2
    c = LOSSES["drivetrain_damping"]["damping_nms_per_rad"] * n**2
    due = -m * G * RISE / (M / RECALLS[0] + K_p * K_t * n**2 + c)
    np.testing.assert_allclose(left[coasts], due, rtol=0.08)  # 100 rows a second


def test_a_loop_that_is_sought_softer_lets_nothing_go_in_a_coast():
    """How hard it is drawn there is no figure's to fit: the vehicle's as stated."""
    softer = {"controller.proportional_gain_as_per_rad": 0.3 * 0.25}
    run, _, stated = left_by(COAST, ROAD)
    _, _, sought = left_by(COAST, ROAD, softer)
    coasts = in_coast(run) & (run["time_s"] > 6.0)
    np.testing.assert_allclose(sought[coasts], stated[coasts], rtol=0.1)


def test_a_rough_road_moves_it_as_far_in_a_coast_as_in_a_drive():
    corners = np.arange(0, 121, 6.0)
    cycle = Cycle("saw", corners, np.where(np.arange(len(corners)) % 2, 5.0, 0.5))
    rng = np.random.default_rng(3)
    at = np.arange(0, 400, 0.1)
    fade = np.exp(-0.1 / 2.0)
    slope = np.zeros(len(at))
    for k in range(1, len(at)):
        slope[k] = fade * slope[k - 1] + 0.005 * np.sqrt(1 - fade**2) * rng.normal()
    run, _, left = left_by(cycle, (at, slope))
    moves = run["speed_mps"] > 1.0
    coasts = moves & (run["motor_current_a"] == 0)
    drives = moves & (run["motor_current_a"] > 0)
    assert min(coasts.sum(), drives.sum()) > 2000
    share = float(np.std(left[coasts]) / np.std(left[drives]))
    assert share == pytest.approx(1.0, abs=0.3)
