"""A profile that stood for another cause is taken back; one that acts stays."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.profile import Profile, with_acting
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.search.leave_out import without_outdone
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

CAR = load_vehicle("rcc")
DAMPING, LOAD = (
    "effects.drivetrain_damping.damping_nms_per_rad",
    "effects.auxiliary_load.power_w",
)
MORE = 2e-5  # N m s/rad, that the file does not know
NOISE = {"speed_mps": 0.005, "battery_voltage_v": 0.02, "battery_current_a": 0.1}


def hump(time):
    """A load [W] that comes and goes once."""
    return 6.0 * np.exp(-(((time - 30.0) / 8.0) ** 2))


def driven(load):
    rng = np.random.default_rng(2)
    time = np.arange(0.0, 60.0, 0.02)
    speed = 2.0 + 1.2 * np.sin(time / 4) + 0.6 * np.sin(time / 1.7)
    made = Trace({"time_s": time, "speed_mps": speed, "aux_power_w": load}, name="made")
    stated = CAR.figures()[DAMPING].value
    truth = CAR.changed(settings={DAMPING: stated + MORE})
    seen = replay(truth, drive_of(made, truth))
    log = {c: seen[c] + rng.normal(0, sd, len(time)) for c, sd in NOISE.items()}
    return Trace({"time_s": time, **log}, name="log")


@pytest.mark.parametrize("acts", [False, True])
def test_a_profile_stays_where_nothing_does_as_well_without_it(acts):
    time = np.arange(0.0, 60.0, 0.02)
    engine = Engine([problem_of(driven(acts * hump(time)), CAR)])
    knots = np.linspace(0.0, 60.0, 31)
    profile = Profile(LOAD, "time_s", knots, hump(knots), np.ones(31), 300.0)
    acting = with_acting(engine, {0: profile})
    knobs = [k for k in nuisance_knobs(engine.problems) if k.key != DAMPING]
    free = Knob(DAMPING, CAR.figures()[DAMPING].value, low=0.0, high=1e-3, step=1e-7)
    fit = descent.fit(acting, {}, [*knobs, free])
    causes = [
        Cause("drivetrain_damping", (DAMPING,), 500.0),
        Cause("auxiliary_load", (LOAD,), 300.0, profiles={0: profile}),
    ]
    after, left, now = without_outdone(acting, causes, fit)
    assert [c.effect for c in left] == [c.effect for c in causes[: 1 + acts]]
    assert (after is acting) == acts
    found = now.values[DAMPING] - CAR.figures()[DAMPING].value
    assert found == pytest.approx(MORE, rel=0.1)
