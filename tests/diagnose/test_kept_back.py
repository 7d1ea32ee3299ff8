"""A log that was kept back speaks for a cause if it has it, and against it if not."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.proof.shrink import kept_back
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.report.screen import screen
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

CAR = load_vehicle("r1t_epa")
LOAD = "effects.auxiliary_load.power_w"
BARE = CAR.figures()[LOAD].value if LOAD in CAR.figures() else 0.0
HEATED = {LOAD: BARE + 4000.0}
COLUMNS = ("time_s", "speed_mps", "battery_voltage_v", "battery_current_a")


def log(name, settings, seed, cycle="udds[0:300]"):
    vehicle = CAR.changed(settings=settings)
    run = simulate(vehicle, parse_cycle(cycle), imposed=True, output_rate=5.0).trace
    rng = np.random.default_rng(seed)
    columns = {c: run[c].copy() for c in COLUMNS}
    for c, sd in (("battery_voltage_v", 0.2), ("battery_current_a", 0.5)):
        columns[c] += rng.normal(0, sd, len(run))
    return Trace(columns, name=name)


def shrink(settings):
    other = Engine([problem_of(log("other", settings, 1), CAR)])
    return kept_back(other, HEATED, {})


def test_it_shrinks_where_the_cause_acts():
    found = shrink(HEATED)
    assert found.explained > 0.98
    assert found.low > 0.9


def test_it_grows_where_the_cause_does_not_act():
    found = shrink({})
    assert found.explained == -1.0
    assert found.after > found.before


@pytest.mark.slow
def test_the_report_says_on_which_log():
    opened = [
        Logged(log(name, HEATED, seed), (), None)
        for name, seed in (("first.csv", 2), ("second.csv", 3))
    ]
    found = diagnose(opened[:1], CAR, holdouts=opened[1:])
    assert [a.cause.effect for a in found.asserted] == ["auxiliary_load"]
    assert found.document()["shrink"]["logs"] == ["second.csv"]
    proof = next(line for line in screen(found, 100) if line.startswith("PROOF"))
    assert "second.csv" in proof


@pytest.mark.slow
def test_a_cause_that_it_lacks_is_withdrawn_and_said_to_be():
    opened = [
        Logged(log(name, settings, seed), (), None)
        for name, settings, seed in (("hot.csv", HEATED, 2), ("cold.csv", {}, 3))
    ]
    found = diagnose(opened[:1], CAR, holdouts=opened[1:])
    assert found.status == "unexplained"
    assert not found.asserted
    assert found.document()["shrink"]["withdrawn"] == ["auxiliary_load"]
    against = "".join(screen(found, 200)).partition("AGAINST")[2]
    assert against.strip().startswith("auxiliary_load")
    assert "cold.csv: withdrawn" in against
