"""What a vehicle's file states with a tolerance is no cause within it."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.fitting.without import refitted_without, without
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.search.leave_out import without_idle
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

OFFSET, SD = "effects.steering_offset.angle_rad", 0.01  # rad
ROLLS = "effects.rolling_resistance.coefficient"
CAR = load_vehicle("rcc").changed(settings={OFFSET: {"value": 0.0, "sd": SD}})
NOISE = {"speed_mps": 0.003, "yaw_rate_radps": 0.02, "battery_current_a": 0.06}


def engine_of(true):
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 40.0, 0.02)
    v = np.interp(
        t, [0, 2, 5, 10, 14, 20, 22, 30, 34, 40], [0, 0, 4, 4, 2, 2, 5, 5, 0, 0]
    )
    steer = 0.05 * np.sin(2.0 * t) * (v > 1)
    commands = {"time_s": t, "speed_ref_mps": v, "steer_cmd_rad": steer}
    seen = replay(CAR.changed(settings=true), drive_of(Trace(commands), CAR, 0.02))
    log = {c: seen[c] + sd * rng.standard_normal(len(t)) for c, sd in NOISE.items()}
    return Engine([problem_of(Trace(commands | log, name="log"), CAR)])


def fits(engine, start):
    """Within tolerances but for the rolling; and with the trim as a cause, too."""
    stated = nuisance_knobs(engine.problems)
    rolls = Knob(ROLLS, start[ROLLS], low=0.0, step=4e-4)
    trim = Knob(OFFSET, start[OFFSET], low=-0.3, high=0.3, step=1e-4)
    within = descent.fit(engine, start, [*stated, rolls])
    free = [k for k in stated if k.key != OFFSET]
    return within, descent.fit(engine, start, [*free, rolls, trim])


def test_a_figure_within_its_tolerance_is_not_missed():
    true = {OFFSET: 2.2 * SD, ROLLS: 0.03}
    engine = engine_of(true)
    within, fit = fits(engine, true)
    held = engine.attempt(
        fit.values | {OFFSET: 0.0}, fit.holding(OFFSET).knobs, fit.noise
    )
    assert fit.score - held.score > 500  # at what the file says it would be far off
    back = without(engine, fit, [OFFSET])
    assert back.values[OFFSET] == 0.0
    less = refitted_without(engine, fit, [OFFSET])
    assert less.score == pytest.approx(within.score, abs=0.3)
    assert less.values[OFFSET] == pytest.approx(true[OFFSET], rel=0.05)
    assert fit.score - less.score == pytest.approx(0.5 * 2.2**2, abs=0.5)


def test_what_no_file_states_is_back_at_nil():
    true = {OFFSET: 0.0, ROLLS: 0.03}
    engine = engine_of(true)
    _, fit = fits(engine, true)
    less = refitted_without(engine, fit, [ROLLS])
    assert ROLLS not in less.values
    assert fit.score - less.score > 100


@pytest.mark.parametrize(("sds", "stays"), [(2.2, False), (9.0, True)])
def test_a_cause_is_idle_while_the_tolerance_of_its_figure_would_do(sds, stays):
    true = {OFFSET: sds * SD, ROLLS: 0.03}
    engine = engine_of(true)
    _, fit = fits(engine, true)
    causes = [
        Cause("steering_offset", (OFFSET,), 2000.0),
        Cause("rolling_resistance", (ROLLS,), 400.0),
    ]
    left, now = without_idle(engine, causes, fit)
    assert {c.effect for c in left} == {"steering_offset", "rolling_resistance"} - (
        set() if stays else {"steering_offset"}
    )
    assert now.values[OFFSET] == pytest.approx(true[OFFSET], rel=0.05)
