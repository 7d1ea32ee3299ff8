"""What a log would tell, and what it would not: said beforehand, and borne out."""

from math import inf
from pathlib import Path

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.causes.detect import Shown, least_seen, shows_likely
from rcc_sim.diagnose.causes.sought import Search
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace, write_trace

DART = Path(__file__).resolve().parents[3] / "shared/data/real_rc/dart_jetracer"
NOISE = {"speed_mps": 0.0026, "battery_voltage_v": 0.015, "battery_current_a": 0.06}
LOAD = "effects.auxiliary_load.power_w"


def test_the_least_that_shows_follows_the_square_law():
    search = Search("effects.a.b", 2.0, 0.0, 100.0, 3.0, most=20.0)
    tried = [Shown(3.0, 0.5), Shown(12.0, 50.0)]  # nats = change²/2
    assert least_seen(search, tried[:1], 18.0) == pytest.approx(6.0)
    assert least_seen(search, tried, 18.0) == pytest.approx(6.0)
    assert least_seen(search, [Shown(3.0, 0.01)], 18.0) is None  # 42 is not usual
    assert least_seen(search, [], 18.0) is None


def test_a_grid_tells_nothing_beyond_it_and_a_limit_its_highest():
    grid = (0.1, 0.2)
    search = Search("effects.a.b", 0.0, 0.0, 1.0, 0.1, grid)
    assert least_seen(search, [Shown(0.1, 4.0), Shown(0.2, 17.0)], 18.0) is None
    told = least_seen(search, [Shown(0.1, 9.0), Shown(0.2, 36.0)], 18.0)
    assert told == pytest.approx(0.1 + 0.1 * (18**0.5 - 3) / 3)
    limit = Search("effects.a.b", inf, 0.0, inf, 5.0, (5.0, 10.0, 20.0))
    tried = [Shown(5.0, 90.0), Shown(10.0, 30.0), Shown(20.0, 1.0)]
    assert least_seen(limit, tried, 18.0) == 10.0


def test_what_shows_at_its_likely_strength_is_identifiable():
    lag = Search("effects.a.b", 0.0, 0.0, 1.0, 0.08, most=0.3, likely=0.08)
    assert shows_likely(lag, 0.05)
    assert not shows_likely(lag, 0.1)  # 0.3 would show, and is not likely
    assert not shows_likely(lag, None)
    limit = Search("effects.a.b", inf, 0.0, inf, 5.0)
    assert shows_likely(limit, 20.0) and not shows_likely(limit, None)


def test_of_what_runs_over_decades_the_middle_is_likely():
    car = load_vehicle("dart_jetracer").changed(without=("motor_lag",))
    t = np.arange(0.0, 10.0, 0.1)
    log = {"time_s": t, "throttle": 0.3 * (t > 1), "speed_mps": np.minimum(t, 1.0)}
    able = candidates_for([problem_of(Trace(log, name="log"), car)])
    searches = {c.effect: c.searches[0] for c in able}
    assert searches["motor_lag"].likely == pytest.approx((0.02 * 0.3) ** 0.5)
    assert searches["gear_loss"].likely == pytest.approx(0.15)


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """Return what the diagnosis of a small car says, drawing so much power more."""
    car = load_vehicle("rcc")
    udds = parse_cycle("udds")
    slow = Cycle("udds at 0.4", udds.time_s, 0.4 * udds.speed_mps)

    def found(power):
        true = car.changed(settings={LOAD: power})
        trace = simulate(true, slow.slice(20, 80)).trace
        rng = np.random.default_rng(11)
        seen = {
            n: trace[n] + NOISE.get(n, 0.0) * rng.normal(size=len(trace))
            for n in ("time_s", "speed_ref_mps", *NOISE)
        }
        path = tmp_path_factory.mktemp("seen") / "log.csv"
        with path.open("wb") as file:
            write_trace(Trace(seen, name=path.name), file)
        return diagnose([open_log(path, car)], car)

    return found


@pytest.mark.slow
def test_a_load_shows_well_above_what_the_log_would_tell_and_not_well_below(driven):
    least = driven(0.0).found.least_seen["auxiliary_load"]["power_w"]
    assert least is not None
    more = driven(2.5 * least)
    assert [a.cause.effect for a in more.asserted] == ["auxiliary_load"]
    assert not driven(0.3 * least).asserted


@pytest.mark.skipif(not DART.exists(), reason="no DART logs beside the project")
def test_darts_step_inputs_do_not_determine_its_motors_lag():
    car = load_vehicle("dart_jetracer")
    logs = sorted((DART / "19_step_input_data").glob("*.csv"))[2:3]
    found = diagnose([open_log(log, car) for log in logs], car)
    assert "motor_lag" in found.not_identifiable
    assert "throttle_dead_zone" not in found.not_identifiable
