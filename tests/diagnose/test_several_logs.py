"""Several logs at once: each driven its own way, none making up for another."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.profile import Profile, with_acting
from rcc_sim.diagnose.deliver import beyond, way_out
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.judge.stands import varying_as
from rcc_sim.diagnose.proof.hold_out import energies, energy_percent
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.search.ways import every_way, kept_alike
from rcc_sim.physics.tables import BEFORE, LINE, SINCE
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from tests import scaled_drive

CAR = load_vehicle("r1t_epa")
RCC = load_vehicle("rcc")
LOAD, SLOPE = "effects.auxiliary_load.power_w", "effects.road_grade.slope"


def imposed(name, times=1.0, direction=1.0):
    """A drive of which the battery's power is so many times the model's."""
    run = simulate(CAR, parse_cycle("udds[0:120]"), imposed=True, output_rate=5.0)
    columns = {c: run.trace[c].copy() for c in ("time_s", "speed_mps")}
    columns["battery_power_w"] = times * run.trace["battery_power_w"]
    columns["direction"] = np.full(len(run.trace), direction)
    return problem_of(Trace(columns, name=name), CAR)


@pytest.fixture(scope="module")
def commanded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drive")
    log = scaled_drive.logged(scaled_drive.drive(RCC, None), RCC, 3, folder).log
    return problem_of(log, RCC)


def test_what_one_takes_too_much_is_not_what_another_takes_too_little():
    logs = [imposed("more.csv", 1.1), imposed("less.csv", 0.9)]
    each = [energy_percent([p], [({}, None)]) for p in logs]
    assert each == pytest.approx([100 / 11, -100 / 9], rel=1e-3)
    taken = [energies(p, {})[0] for p in logs]
    both = energy_percent(logs, [({}, None)])
    assert both == pytest.approx(np.dot(np.abs(each), taken) / sum(taken), rel=1e-6)


def test_a_log_without_a_battery_has_the_energy_of_its_shaft(commanded):
    log = commanded.log
    bare = {
        c: x for c, x in log.columns.items() if not c.startswith("battery") and x.any()
    }
    problem = problem_of(Trace(bare, name="no battery.csv"), RCC)
    measured, simulated = energies(problem, {})
    assert simulated == pytest.approx(measured, rel=0.05) and measured > 0


def test_logs_of_other_rates_are_asked_every_way_together(commanded):
    """The window of each is its own.

    Of a drive that is imposed the steering alone is asked, whatever drives the car.
    """
    other = replace(commanded, drive=replace(commanded.drive, window=0.003))
    speed = replace(commanded, drive=replace(commanded.drive, imposed=True))
    ways = every_way([commanded, other, speed])
    held = {tuple(d.held for d in some[:2]) for some in ways}
    straight, holds = (LINE, LINE), (SINCE, SINCE)
    assert {(straight, straight), (holds, holds)} <= held
    assert all(first == second for first, second in held)
    assert all(some[2].held == (LINE, some[0].held[1]) for some in ways)
    assert all(some[2].window == speed.drive.window for some in ways)
    windows = {tuple(d.window for d in some[:2]) for some in ways}
    assert (commanded.drive.window, 0.003) in windows
    alone = every_way([speed])
    each_way = [(LINE, how) for how in (LINE, SINCE, BEFORE)]
    assert [some[0].held for some in alone] == each_way
    by_wire = every_way([replace(speed, vehicle=load_vehicle("r1t"))])
    assert [some[0].held for some in by_wire] == each_way
    steady = replace(speed, drive=replace(speed.drive, steered=False))
    assert every_way([steady]) == []


def profile(key, along, at):
    knots = np.linspace(at[0], at[-1], 12)
    return Profile(key, along, knots, 1e-3 + 0 * knots, np.ones(12), 100.0)


def test_a_profile_that_is_withdrawn_acts_no_more():
    bare = Engine([imposed("log.csv")])
    (problem,) = bare.problems
    hill = profile(SLOPE, "distance_m", problem.distance)
    load = profile(LOAD, "time_s", problem.log["time_s"])
    load = replace(load, value=load.value + 500.0)
    causes = [
        Cause("road_grade", (SLOPE,), 100.0, profiles={0: hill}),
        Cause("auxiliary_load", (LOAD,), 100.0, profiles={0: load}),
    ]
    both = with_acting(with_acting(bare, {0: hill}), {0: load})
    found = SimpleNamespace(engine=both, causes=tuple(causes))
    assert varying_as(bare, found, causes) is both
    alone = varying_as(bare, found, causes[:1])
    residuals = alone.residuals({})[0] - both.residuals({})[0]
    assert np.median(residuals) == pytest.approx(500.0, rel=0.05)


def test_a_road_is_written_as_the_way_out_goes():
    out, back = imposed("out.csv"), imposed("back.csv", direction=-1.0)
    assert back.drive.back and not out.drive.back
    hill = profile(SLOPE, "distance_m", out.distance)
    rising = replace(hill, value=np.linspace(-0.01, 0.03, 12))
    told = {0: replace(rising, value=rising.value[::-1]), 1: rising}

    def found(problems, shown):
        engine = SimpleNamespace(problems=problems)
        return SimpleNamespace(found=SimpleNamespace(engine=engine), shown=shown)

    both = Cause("road_grade", (SLOPE,), 100.0, profiles=told)
    assert way_out(found([back, out], 0), both) is told[1]
    assert way_out(found([out, out], 0), both) is told[0]
    alone = way_out(found([back], 0), replace(both, profiles={0: told[0]}))
    np.testing.assert_allclose(alone.value, rising.value)
    np.testing.assert_allclose(alone.knots, rising.knots, atol=1e-9)


def test_a_road_beside_a_slope_of_all_logs_adds_up_to_its_own():
    """What is written is less what the file will state, whatever its own mean is."""
    own = profile(SLOPE, "distance_m", np.array([0.0, 100.0]))
    knots, value = beyond(own, 0.004)
    np.testing.assert_allclose(value[:-1] + 0.004, own.value)
    assert value[-1] + 0.004 == 0.0 and knots[-1] > own.knots[-1]


def test_a_log_kept_back_is_driven_as_those_that_were_fitted(commanded):
    """Commands that hold in the one hold in the other: one logger wrote both."""
    holds = replace(commanded, drive=replace(commanded.drive, held=(SINCE, LINE)))
    (other,) = kept_alike([commanded], Engine([holds]))
    assert other.drive.held == (SINCE, LINE)
    assert other.drive.window == commanded.drive.window
    speed = imposed("speed.csv")
    assert kept_alike([speed], Engine([holds]))[0] is speed
