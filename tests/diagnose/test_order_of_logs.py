"""What is sought in several logs does not hang on which of them comes first."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.errors import InputError
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace

CAR = load_vehicle("rcc")


@pytest.fixture(scope="module")
def problems():
    """A drive with its commands, and the speed and power of one that are all known."""
    cycle = scale_cycle(parse_cycle("udds[20:80]"), to=CAR, of=load_vehicle("r1t"))
    run = simulate(CAR, cycle.cycle, lanes=LaneChanges(2.0), output_rate=50.0).trace
    noise = np.random.default_rng(1).normal(0, 0.01, len(run))
    log = Trace({**run.columns, "speed_mps": run["speed_mps"] + noise}, name="whole")
    poor = {c: log[c] for c in ("time_s", "speed_mps", "battery_power_w")}
    return [problem_of(x, CAR) for x in (log, Trace(poor, name="poor"))]


def sought(problems):
    return {c.effect: {s.key for s in c.searches} for c in candidates_for(problems)}


def test_the_order_changes_no_candidate_and_no_tolerance(problems):
    whole, poor = problems
    assert sought([whole, poor]) == sought([poor, whole])
    keys = [
        {k.key for k in nuisance_knobs(some) if not k.key.startswith("bias.")}
        for some in ([whole, poor], [poor, whole])
    ]
    assert keys[0] == keys[1]


def test_what_one_log_could_show_is_sought_in_both(problems):
    whole, poor = problems
    alone = sought([poor])
    assert "steering_offset" not in alone and "actuation_delay" not in alone
    # beside a speed that was smoothed no slip is sought, in whatever log
    either = {*sought([whole]), *alone} - {"longitudinal_slip"}
    assert either == {*sought([poor, whole])}


def test_an_effect_that_none_could_show_is_refused(problems):
    with pytest.raises(InputError, match="steering_offset: cannot show"):
        candidates_for(problems[1:], ["steering_offset"])
    assert candidates_for(problems[::-1], ["steering_offset"])
