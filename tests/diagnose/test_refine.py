"""Candidates that stand behind tolerances which were pulled far."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.sought import Search
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.search.refine import contenders, likely, refine
from rcc_sim.diagnose.search.starts import released, screened

FACTOR = Candidate("factor", (Search("factor", 1.0, 0.1, 5.0, 1.1, acts="factor"),))
NOISE = 0.006
STATED = Knob("stated", 1.0, 0.05, low=0.05, acts="factor")


@pytest.fixture
def engine():
    """A decay that an effect speeds up by half, beside its stated rate."""
    rng = np.random.default_rng(3)
    t = np.linspace(0, 3, 4000)
    seen = np.exp(-1.5 * t) + NOISE * rng.normal(size=len(t))
    engine = object.__new__(Engine)  # without a log
    engine.problems = ()
    engine.tracks = [(0, "seen")]
    engine.valid = [np.ones(len(t), dtype=bool)]
    engine.grows_with, engine.edges, engine.least = [[]], [[]], [0.0]
    engine.memory = [None]
    engine.stands = [None]
    engine.residuals = lambda v, coarse=False: [
        seen - np.exp(-v["stated"] * v.get("factor", 1.0) * t)
    ]
    engine.gains = lambda less, more: np.full(25, (more.score - less.score) / 21)
    return engine


def test_a_figure_far_off_gives_way_to_the_effect_that_multiplies_it(engine):
    null = descent.fit(engine, {}, [STATED])
    assert null.values["stated"] == pytest.approx(1.5, abs=0.01)  # ten sds, 50 nats
    best = refine(engine, null, screened(engine, null, [FACTOR]))[0]
    assert best.fit.values["factor"] == pytest.approx(
        1.5, abs=0.05
    )  # it cannot be told better
    assert best.fit.values["stated"] == pytest.approx(1.0, abs=0.04)
    assert best.gain == pytest.approx(50, rel=0.05)


def test_a_threshold_that_only_the_screen_promises_hides_no_effect(engine):
    null = descent.fit(engine, {}, [STATED])
    ((real, start), *_) = screened(engine, null, [FACTOR])
    idle = Candidate("idle", (Search("idle", 0.0, 0.0, 5.0, 1.0),))  # acts on nothing
    loud = replace(real, candidate=idle, values={"idle": 1.0}, gain=100 * real.gain)
    found = [(loud, null), (real, start)]
    assert [r.candidate.effect for r, _ in likely(found, 18.0)] == ["idle"]
    best, *_ = contenders(engine, null, found, 18.0)
    assert best.screened.candidate.effect == "factor"
    assert best.reaches(18.0)


def test_a_twin_that_is_refined_no_further_is_known_as_well_as_the_best(engine):
    """It may be named in place of the best: what it changes must be known."""
    twin = Candidate("twin", (Search("factor", 1.0, 0.1, 5.0, 1.1, acts="factor"),))
    null = descent.fit(engine, {}, [STATED])
    both = refine(engine, null, screened(engine, null, [FACTOR, twin]))
    assert len(both) == 2
    for one in both:
        assert len(one.fit.signals) == len(one.fit.knobs) == 2
        assert one.gain == pytest.approx(50, rel=0.05)


def test_a_gain_too_small_by_one_noise_is_not_asked_for_the_other(engine):
    """Noise of the best is learnt for what may be named alone."""
    null = descent.fit(engine, {}, [STATED])
    learnt = []
    learn = engine.learn_noise
    engine.learn_noise = lambda left: learnt.append(left) or learn(left)
    found = screened(engine, null, [FACTOR])
    refine(engine, null, found, needed=500.0)
    assert not learnt
    refine(engine, null, found, needed=40.0)
    assert learnt


def test_nothing_is_followed_where_the_figures_are_as_stated(engine):
    null = descent.fit(engine, {}, [Knob("stated", 1.5, 0.05)])
    assert max(r.gain for r, _ in screened(engine, null, [FACTOR])) < 3


def test_an_effects_own_figure_that_was_pulled_far_is_the_effect(engine):
    """No strength of its grid comes as near as where the tolerance went."""
    null = descent.fit(engine, {}, [STATED])
    grid = Candidate("own", (Search("stated", 1.0, 0.1, 5.0, 1.2, grid=(1.2, 1.9)),))
    best = refine(engine, null, screened(engine, null, [grid]))[0]
    assert best.fit.values["stated"] == pytest.approx(1.5, abs=0.01)
    assert best.gain == pytest.approx(-null.prior, rel=0.05)
    near = descent.fit(engine, {}, [Knob("stated", 1.5, 0.05)])
    assert max(r.gain for r, _ in screened(engine, near, [grid])) <= 0


def test_a_figure_that_left_what_its_effect_may_be_is_taken_back_to_the_bound():
    payload = "effects.payload.mass_kg"
    mass = Knob("body.mass_kg", 1500.0, 50.0)
    search = Search(payload, 0.0, -100.0, 500.0, 10.0, same_as=mass.key)
    lighter = Candidate("payload", (search,))
    fit = Fit({mass.key: 300.0}, (mass,), 0.0, 0.0, [], [])
    seen = {}

    def at(fit, values):
        seen.update(values)
        return fit

    engine = SimpleNamespace(at=at)
    ((one, _),) = released(engine, fit, [lighter])
    assert one.values == {payload: -100.0}
    assert seen == {mass.key: 1500.0, payload: -100.0}


def test_a_loss_that_was_pulled_far_may_be_another_that_acts_alike():
    eddy, damping = (
        "effects.iron_loss.eddy_nms_per_rad",
        "effects.drivetrain_damping.damping_nms_per_rad",
    )
    iron = Candidate("iron_loss", (Search(eddy, 0.0, 0.0, 1.0, 1e-5, same_as=damping),))
    stated = Knob(damping, 2e-5, 1e-6, low=0.0)
    fit = Fit({damping: 2.8e-5}, (stated,), 0.0, -32.0, [], [])
    engine = SimpleNamespace(at=lambda fit, values: fit)
    ((one, _),) = released(engine, fit, [iron])
    assert one.values == {eddy: pytest.approx(8e-6)}
    assert one.gain == pytest.approx(32.0)  # what the file's sd charged for it
    near = Fit({damping: 2.2e-5}, (stated,), 0.0, -2.0, [], [])
    assert released(engine, near, [iron]) == []
