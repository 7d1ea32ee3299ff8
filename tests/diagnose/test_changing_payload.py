"""A load that gets in and out at stops acts as a mass, and as nothing else.

The log is worked out by hand, not by the model.
"""

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d

from rcc_sim.analyse.logged import Logged
from rcc_sim.diagnose.run import diagnose
from rcc_sim.report.screen import screen
from rcc_sim.trace import Trace
from rcc_sim.units import G
from tests.by_hand import AREA, AUX, PER_SPEED, RHO, ROLL, STATED
from tests.cars import TRUCK, truck

CAR, STOP = truck(STATED), 60.0
LADEN = np.array([0, 900, 900, 300, 0, 700, 1200, 1200, 500, 0, 0, 600, 600, 0, 900])
"""Mass that is on board from one stop to the next. [kg]"""


def town(laden, row, seed):
    """A quarter of an hour with a stop each minute; rows hold means of what flows."""
    rng = np.random.default_rng(seed)
    fine = np.arange(0.0, 900.0, 0.05)
    phase = fine % STOP
    v = np.clip(np.minimum(1.3 * (phase - 8), 1.1 * (58 - phase)), 0.0, 13.0)
    v = uniform_filter1d(uniform_filter1d(v, 21), 21)  # no jerk without end
    mass = TRUCK["body"]["mass_kg"] + laden[(fine // STOP).astype(int)]
    drag = 0.5 * RHO * AREA * v**2 + mass * G * ROLL
    torque = (v > 0) * (mass * np.gradient(v, fine) + drag) / PER_SPEED
    power = torque * v * PER_SPEED + AUX
    n = round(row / 0.05)
    mean = power[: len(power) // n * n].reshape(-1, n).mean(1)
    t, rows = fine[::n], len(fine[::n])
    noise = 150.0 * rng.normal(size=rows)
    columns = {
        "time_s": t,
        "speed_mps": np.clip(v[::n] + 0.01 * rng.normal(size=rows), 0.0, None),
        "battery_power_w": np.append(mean[:1], mean[: rows - 1]) + noise,
    }
    return [Logged(Trace(columns, name="town"), (), None)]


@pytest.mark.parametrize("row", [0.1, 1.0])
def test_a_load_that_changes_at_stops_is_told_as_a_mass(row):
    found = diagnose(town(LADEN, row, 1), CAR)
    assert (found.status, found.asserted) == ("unexplained", ())
    assert (found.left.acts_as, found.left.follows) == ("mass", "time_s")
    course = found.left.profile
    middles = STOP * (np.arange(len(LADEN)) + 0.6)
    apart = course.at(middles) - course.at(middles).mean() - (LADEN - LADEN.mean())
    assert np.sqrt(np.mean(apart**2)) < 0.4 * LADEN.std()
    assert any("acts as a mass" in line for line in screen(found))


def test_a_load_that_stays_is_a_payload_and_nothing_is_left():
    (one,) = diagnose(town(np.full(15, 800), 0.1, 2), CAR).asserted
    assert one.cause.effect == "payload"
    assert one.figures["mass_kg"].value == pytest.approx(800, rel=0.06)


def test_no_load_is_no_gap():
    assert diagnose(town(np.zeros(15, int), 0.1, 3), CAR).status == "no_gap"
