"""Logs that do not go together are told: what mends one makes the other worse."""

import numpy as np
import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.proof.by_log import LogEnergy
from rcc_sim.diagnose.proof.hold_out import energy_by_log
from rcc_sim.diagnose.proof.proven import opens_gaps
from rcc_sim.diagnose.residuals.posed import by_motion, problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.report.screen import screen
from rcc_sim.report.verdict import verdict_of
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace, write_trace
from tests.diagnose.test_verdict import CAUSE, NOTHING, comes_to

ROLLS, KEY = 0.028, "effects.rolling_resistance.coefficient"
NOISE = {"speed_mps": 0.03, "accel_x_mps2": 0.05, "battery_power_w": 40.0}


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """A Twizy on soft tyres, twice, and one as its file says."""
    folder, car = tmp_path_factory.mktemp("logs"), load_vehicle("twizy")
    soft = car.changed(settings={KEY: ROLLS})
    made = []
    for k, true in enumerate((soft, soft, car)):
        run = simulate(
            true, parse_cycle("udds[20:320]"), imposed=True, output_rate=10.0
        )
        rng = np.random.default_rng(k)
        columns = {"time_s": run.trace["time_s"]} | {
            c: run.trace[c] + rng.normal(0, sd, len(run.trace))
            for c, sd in NOISE.items()
        }
        path = folder / f"log{k}.csv"
        with path.open("wb") as file:
            write_trace(Trace(columns), file)
        made.append(open_log(path, car))
    return car, made


def test_the_energy_of_each_log_is_that_of_its_own_gap(logs):
    """Another route: `gap`, which runs the mended vehicle by itself."""
    car, made = logs
    found = energy_by_log(
        [by_motion(problem_of(one.log, car)) for one in made], {KEY: ROLLS}
    )
    mended = car.changed(settings={KEY: ROLLS})
    each = [gap(one, mended).energy.gap_percent for one in made]
    assert found == pytest.approx(each, abs=0.3)
    assert found[2] < -15.0 and abs(found[0]) < 2.0


@pytest.mark.slow
def test_a_log_that_does_not_go_with_the_others_is_named(logs):
    car, made = logs
    found = diagnose(made, car)
    assert [one.disagrees for one in found.by_log] == [False, False, True]
    assert found.status in ("partly_explained", "unexplained")
    document = found.document()
    assert [x["disagrees"] for x in document["by_log"]] == [False, False, True]
    assert "log2.csv does not go with the other logs" in verdict_of(document)
    assert any(line.startswith("DOUBT") for line in screen(found))
    left = document["unexplained"]
    assert left.get("log", made[2].log.name) in {one.log.name for one in made}
    assert ("acts_as" in left) == ("log" in left)


@pytest.mark.parametrize(
    ("before", "after", "chance", "disagrees"),
    [
        (4.5, -21.9, 1.0, True),
        (4.5, -21.9, 30.0, False),
        (24.0, 3.0, 1.0, False),
        (1.0, 2.0, 0.1, False),
        (None, None, 1.0, False),
    ],
)
def test_a_gap_that_grows_beyond_chance_disagrees(before, after, chance, disagrees):
    assert LogEnergy("a.csv", before, after, chance).disagrees is disagrees


def test_no_status_is_a_clean_one_where_logs_disagree():
    assert comes_to([], NOTHING, disagree=True) == "unexplained"
    told = comes_to([CAUSE], NOTHING, 20.0, 1.0, disagree=True)
    assert told == "partly_explained"


@pytest.mark.parametrize(
    ("off", "opens"), [([(-0.6, -11.8)], True), ([(-0.6, -11.8), (9.0, 1.0)], False)]
)
def test_a_gap_in_every_log_is_opened(off, opens):
    by_log = [LogEnergy("log", was, now, chance=5.0) for was, now in off]
    assert opens_gaps(by_log) is opens
