"""A profile that is known to act is sharpened under the noise that it leaves."""

from pathlib import Path

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.profiles.varying import WINDOW_COUNTS
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.trace import Trace

DATA = Path(__file__).resolve().parents[3] / "shared/data"
TRIP = DATA / "real_ev/bmw_i3_tum/TripA23.csv.gz"


@pytest.mark.slow
@pytest.mark.skipif(not TRIP.is_file(), reason="the BMW logs are not here")
def test_a_real_heater_is_followed_once_the_coarse_of_it_is_known():
    car = load_vehicle("bmw_i3")
    log = open_log(TRIP, car, hide=["aux_power_w"])
    found = diagnose([log], car, candidates=("auxiliary_load", "payload"))
    first = found.asserted[0].cause
    assert first.effect == "auxiliary_load"
    measured = open_log(TRIP, car).log
    heater = first.profiles[0].at(measured["time_s"])
    known = np.isfinite(measured["aux_power_w"])
    off = (heater - measured["aux_power_w"])[known]
    knots = first.profiles[0].knots
    assert np.diff(knots).min() < (knots[-1] - knots[0]) / max(WINDOW_COUNTS)
    assert np.corrcoef(heater[known], measured["aux_power_w"][known])[0, 1] > 0.97
    assert np.abs(off.mean()) < 150


def test_profiles_add_up_knot_by_knot():
    def profile(knots, value):
        nothing = np.zeros(len(knots))
        return Profile("x", "time_s", np.array(knots), np.array(value), nothing, 1.0)

    a, b = profile([0.0, 4.0], [1.0, 5.0]), profile([0.0, 1.0, 4.0], [0.0, 3.0, 0.0])
    t = np.linspace(0, 4, 17)
    assert a.plus(b).at(t) == pytest.approx(a.at(t) + b.at(t))


def test_slopes_add_up():
    t = np.arange(0.0, 60.0, 0.1)
    speed = 15 + 6 * np.sin(t / 17) + 3 * np.sin(t / 5.3)
    log = Trace({"time_s": t, "speed_mps": speed})
    problem = problem_of(log, load_vehicle("tesla_model_3"))
    s = problem.distance
    hill = np.array([0.0, 100.0, 300.0]), np.array([0.0, 0.02, 0.0])
    dip = np.array([0.0, 150.0, 400.0]), np.array([0.01, -0.03, 0.0])
    both = np.interp(s, *hill) + np.interp(s, *dip)
    one = problem.on_road(s, both).predict({})
    two = problem.on_road(*hill).on_road(*dip).predict({})
    for column in ("battery_power_w", "accel_x_mps2", "motor_torque_nm"):
        assert two[column] == pytest.approx(one[column], rel=5e-3, abs=1e-2)
