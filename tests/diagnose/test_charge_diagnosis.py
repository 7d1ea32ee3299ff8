"""A hill that only the state of charge shows."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.causes.strengths import freed
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.judge.asserted import estimates
from rcc_sim.diagnose.noise.strips import Strips
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.diagnose.search.compete import compete
from rcc_sim.diagnose.signatures import signatures
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

TWIZY = load_vehicle("twizy")


def driven(climbs, seed=1, car=TWIZY):
    """A drive of an hour with noisy power, logged by speed and charge alone."""
    rng = np.random.default_rng(seed)
    time = np.arange(3600.0)
    speed = 9 + 4 * np.sin(time / 60) + np.convolve(
        rng.normal(0, 1, len(time)), np.ones(30) / 30, "same"
    )  # fmt: skip
    distance = np.cumsum(speed)
    slope = climbs * np.sin(distance / 900)
    columns = {"time_s": time, "speed_mps": speed, "slope": slope + 1e-9}
    drive = drive_of(Trace(columns, name="true"), car, 1e9)
    power = replay(car, drive)["battery_power_w"] + rng.normal(0, 800, len(time))
    charge = 95 - 100 * np.cumsum(power) / TWIZY.battery_energy
    columns["state_of_charge_percent"] = np.round(charge / 0.02) * 0.02
    del columns["slope"]
    return Trace(columns, name="charge"), distance, slope


def test_hills_are_found_by_the_charge_and_their_size_is_right():
    log, distance, slope = driven(0.02)
    problem = problem_of(log, TWIZY)
    assert problem.channels == ("battery_power_w",)
    names = ["road_grade", "auxiliary_load", "rolling_resistance", "payload"]
    found = compete(Engine([problem]), candidates_for([problem], names))
    assert found.causes[0].effect == "road_grade"
    climbed = found.causes[0].profiles[0].at(distance)
    gain = np.polyfit(slope, climbed, 1)[0]
    assert 0.7 < gain < 1.3
    assert np.corrcoef(slope, climbed)[0, 1] > 0.9


def test_what_it_shows_stands_at_the_rows_of_the_log():
    """The charge is judged by stretches; a page draws over the log's own rows."""
    log, _, _ = driven(0.02)
    names = ["road_grade", "rolling_resistance", "payload"]
    found = diagnose([Logged(log, (), None)], TWIZY, candidates=names)
    assert found.asserted[0].cause.effect == "road_grade"
    shown = signatures(found)
    assert shown.effects[0].effect == "road_grade"
    assert len(shown.effects) > 1
    acts, left = shown.effects[0].moved["battery_power_w"], shown.left
    assert acts.shape == log["time_s"].shape
    both = np.isfinite(acts) & np.isfinite(left["battery_power_w"])
    assert both.mean() > 0.95
    assert np.corrcoef(acts[both], left["battery_power_w"][both])[0, 1] > 0.5


def test_prices_by_the_charge_sum_to_the_gap_though_speeds_are_missing():
    log, _, _ = driven(0.02)
    late = np.arange(len(log)) % 9 == 0
    speed = np.where(late, np.nan, log["speed_mps"])
    log = Trace({**log.columns, "speed_mps": speed}, name="gaps")
    names = ["road_grade", "rolling_resistance"]
    found = diagnose([Logged(log, (), None)], TWIZY, candidates=names)
    told = found.prices
    whole = sum(told.causes.values()) + told.figures_wh + told.unexplained_wh
    assert whole == pytest.approx(found.gap.energy.gap_wh, rel=1e-9)


def test_a_tie_by_the_charge_is_told_with_a_run_that_could_settle_it():
    heavy = TWIZY.changed(settings={"effects.rolling_resistance.coefficient": 0.035})
    log = driven(0.0, car=heavy)[0]
    names = ["rolling_resistance", "drivetrain_friction"]
    found = diagnose([Logged(log, (), None)], TWIZY, candidates=names)
    (told,) = found.asserted
    assert {told.cause.effect, *told.cause.tied} == set(names)
    assert set(found.experiments[0].document()["separates"]) == set(names)


def test_a_flat_road_has_no_hills():
    problem = problem_of(driven(0.0)[0], TWIZY)
    found = compete(Engine([problem]), candidates_for([problem], ["road_grade"]))
    assert found.causes == ()


@pytest.mark.parametrize("fitted", [{}, {"effects.auxiliary_load.power_w": 300.0}])
def test_a_profile_acts_on_top_of_what_was_fitted_else_stated(fitted):
    key = "effects.auxiliary_load.power_w"
    knots, value = np.arange(4.0), np.array([1000.0, 900, 1100, 1000])
    profile = Profile(key, "time_s", knots, value, np.full(4, 50.0), 99.0)
    cause = Cause("auxiliary_load", (key,), 99.0, 0.0, profiles={0: profile})
    figure = estimates(Fit(fitted, (), 0.0, 0.0, [], []), cause, {key: 450.0})
    assert figure["power_w"].value == 1000 + fitted.get(key, 450.0)


def test_the_interval_of_a_profiles_mean_ends_where_its_effect_does():
    key, knots = "effects.auxiliary_load.power_w", np.arange(4.0)
    profile = Profile(
        key, "time_s", knots, np.full(4, 200.0), knots, 99.0, mean_sd=500.0
    )
    cause = Cause("auxiliary_load", (key,), 99.0, 0.0, profiles={0: profile})
    figure = estimates(Fit({}, (), 0.0, 0.0, [], []), cause, {})["power_w"]
    assert (figure.value, figure.low) == (200.0, 0.0)
    assert figure.high > 200.0


def test_a_knob_that_was_pulled_away_gives_a_profile_its_part_back():
    rows, sd = 400, 0.1
    A, J = np.ones((rows, 1)), np.ones((rows, 1))
    truth = 3.0
    # alone, the knob took all but its prior's share; the profile is free to take it
    taken = truth * rows / (rows + 1 / sd**2)
    r = np.full(rows, -(truth - taken))
    off = np.array([taken])
    M, b, back = freed(Strips.of(A), r, J, np.array([sd]), off)
    value = np.linalg.solve(M, b)
    assert value == pytest.approx([truth])
    assert off + back(value) == pytest.approx([0.0], abs=1e-9)
