"""A course is weighed with all that a log says of the figures that give way to it."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.strengths import windows
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.noise.whitener import weights
from rcc_sim.diagnose.profiles.probe import Probe
from rcc_sim.diagnose.profiles.varying import profile_cause, with_profile
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

SLOPE = "effects.road_grade.slope"
SIZES = {
    "speed_mps": 0.02,
    "yaw_rate_radps": 0.004,
    "accel_x_mps2": 0.08,
    "accel_y_mps2": 0.08,
    "battery_power_w": 300.0,
}


@pytest.fixture(scope="module")
def found():
    """Ten minutes of bends, one after the other, on a road that falls in each of them.

    What bends take and what the road gives there are alike: by power alone a steeper
    fall and a dearer bend are one.
    """
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 600.0, 0.1)
    car = load_vehicle("tesla_model_3")
    v = 14 + 4 * np.sin(t / 31) + 2 * np.sin(t / 7.7)
    bend = np.sin(t / 15.0)
    steer = 0.03 * bend * np.abs(bend)
    drive = {"time_s": t, "speed_mps": v, "steer_cmd_rad": steer}
    distance = np.concatenate([[0.0], np.cumsum(0.05 * (v[1:] + v[:-1]))])
    slope = 0.012 * np.sin(distance / 170) - 0.015 * bend**2
    road = Trace(drive | {"slope": slope + 1e-12})
    seen = replay(car, drive_of(road, car))
    noisy = {c: seen[c] + sd * rng.normal(size=len(t)) for c, sd in SIZES.items()}
    problem = problem_of(Trace(drive | noisy, name="bends"), car)
    engine = Engine([problem])
    fit = descent.of_tolerances(engine)
    probe = Probe(engine, fit, SLOPE)
    x = problem.coordinate("distance_m")
    return (
        probe,
        x,
        probe.profile(0, "distance_m", x, 30),
        np.interp(x, distance, slope),
    )


def test_it_is_what_all_rows_of_all_channels_say_at_once(found):
    """As one dense least-squares problem: strengths, and all figures that give way."""
    probe, x, profile, _ = found
    fit, H = probe.fit, windows(x, profile.knots).toarray()
    rows, right = [], []
    for signal, left, noise, i in zip(
        probe.signal, fit.residuals, fit.noise, range(len(fit.noise)), strict=True
    ):
        J = np.stack([j[i] for j in fit.signals]).T
        both = noise(np.column_stack([signal[:, None] * H, J, left]))
        W = np.sqrt(weights(both[:, -1]))[:, None]
        rows.append((W * both)[:, :-1])
        right.append((W * both)[:, -1])
    k = H.shape[1]
    sd, off = fit.prior_sd, fit.off
    rows.append(np.hstack([np.zeros((len(sd), k)), np.diag(1 / sd)]))
    right.append(off / sd)
    A, r = np.vstack(rows), np.concatenate(right)
    N, b = A.T @ A, -A.T @ r
    rest = N[:k, k:] @ np.linalg.inv(N[k:, k:])
    M, told = profile.normal
    assert M == pytest.approx(
        N[:k, :k] - rest @ N[k:, :k], rel=1e-6, abs=1e-6 * N.max()
    )
    assert told == pytest.approx(
        b[:k] - rest @ b[k:], rel=1e-4, abs=1e-4 * abs(b).max()
    )


def test_a_road_that_falls_in_bends_is_not_paid_for_by_the_tyres(found):
    """Nor by gear, mass and gains of sensors, once the hill acts by its own noise."""
    probe, x, _, slope = found
    cause, _ = profile_cause(probe.engine, probe.fit, {"road_grade"})
    _, fit, hill = with_profile(probe.engine, probe.fit, cause)
    assert fit.prior > probe.fit.prior - 5.0
    off = hill.profiles[0].at(x) - slope
    assert off.std() < 0.2 * slope.std()
