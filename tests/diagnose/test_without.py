"""What a vehicle's file states with a tolerance is no cause within it."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.sought import Search
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.fitting.without import refitted_without, without
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.search.leave_out import without_idle
from rcc_sim.diagnose.search.look import come_to_rest
from rcc_sim.diagnose.search.refine import Refined
from rcc_sim.diagnose.search.screen import Screened
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
    _, left, now = without_idle(engine, causes, fit)
    assert {c.effect for c in left} == {"steering_offset", "rolling_resistance"} - (
        set() if stays else {"steering_offset"}
    )
    assert now.values[OFFSET] == pytest.approx(true[OFFSET], rel=0.05)


def followed(engine, base, key, start):
    """A candidate with one figure, refined beside the base, all others giving way."""
    free = Knob(key, start, low=0.0, step=0.02 * start)
    fit = descent.fit(
        engine, base.values | {key: start}, [*base.knobs, free], base.noise
    )
    gain = engine.judged(fit, base.noise).score - base.score
    search = Search(key, 0.0, 0.0, 1.0, start, most=1.0)
    one = Screened(Candidate(key.split(".")[1], (search,)), gain, {key: start})
    return Refined(one, fit, gain, gain)


@pytest.mark.parametrize("acts", [False, True])
def test_what_others_gain_that_had_not_come_to_rest_is_no_candidates(acts):
    """The trim is 2.2 sds off: beside a fit that holds it at nil, a drag of next to
    nothing gains what the trim does; a drag that acts gains enough beyond that.
    """
    engine = engine_of({OFFSET: 2.2 * SD, ROLLS: 0.03 * acts})
    stated = nuisance_knobs(engine.problems)
    rest = descent.fit(engine, {}, stated)
    early = engine.judged(
        engine.evaluate(rest.values | {OFFSET: 0.0}, stated), rest.noise
    )
    early = replace(early, signals=rest.signals)
    best = followed(engine, early, ROLLS, 0.03 if acts else 1e-4)
    assert best.gain > 500
    after = come_to_rest(engine, early, best)
    assert (after is None) == acts
    if after is not None:
        assert after.score == pytest.approx(rest.score, abs=3.0)
        assert after.values[OFFSET] == pytest.approx(2.2 * SD, rel=0.05)
    assert come_to_rest(engine, rest, followed(engine, rest, ROLLS, 0.02)) is None
