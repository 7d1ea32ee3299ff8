"""What a diagnosis writes: profiles log by log, roads that add up, notes."""

from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.kernel import road_of
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.deliver import (
    refuse_bag,
    varying,
    write_mended,
    write_profiles,
)
from rcc_sim.diagnose.judge.asserted import Asserted, Estimate
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.errors import InputError
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace, read_trace

SLOPE = "effects.road_grade.slope"


def problem(car, seconds):
    t = np.arange(0.0, seconds, 0.1)
    return problem_of(Trace({"time_s": t, "speed_mps": 12 + 3 * np.sin(t / 9)}), car)


def hill(length, height, mean=0.0):
    knots = np.linspace(0.0, length, 5)
    value = mean + height * np.array([0.0, 1.0, 0.0, -1.0, 0.0])
    return Profile(SLOPE, "distance_m", knots, value, 0.001 + 0 * knots, 99.0)


def diagnosis(car, problems, profiles):
    cause = Cause("road_grade", (SLOPE,), 99.0, profiles=profiles)
    stated = car.figures().get(SLOPE)
    mean = float(profiles[0].value.mean()) + (stated.value if stated else 0.0)
    slope = {"slope": Estimate(mean, mean - 0.01, mean + 0.01, 0.006)}
    return SimpleNamespace(
        asserted=[Asserted(cause, 0.99, slope)],
        vehicle=car,
        gaps=[SimpleNamespace(log=f"log{i}.csv") for i in range(len(problems))],
        found=SimpleNamespace(engine=SimpleNamespace(problems=problems)),
        fit=SimpleNamespace(values={}),
        figures=dict,
        shown=0,
        hidden=(),
        effects=lambda: {"road_grade": {"slope": Figure(mean, 0.006)}},
    )


def test_each_log_has_its_own_profile(tmp_path):
    car = load_vehicle("r1t_epa")
    problems = [problem(car, 60.0), problem(car, 90.0)]
    found = diagnosis(car, problems, {0: hill(600, 0.02), 1: hill(900, 0.03)})
    assert varying(found) == ["road_grade"]
    for i, (one, height) in enumerate(zip(problems, (0.02, 0.03), strict=True)):
        path = tmp_path / f"{i}.csv"
        with path.open("wb") as file:
            write_profiles(found, file, i)
        told = read_trace(path)
        assert told["time_s"] == pytest.approx(one.log["time_s"])
        assert told["road_grade.slope"].max() == pytest.approx(height, rel=0.02)


def test_a_road_that_the_file_states_stays_under_what_was_found(tmp_path):
    known = np.array([0.0, 100.0, 1000.0]), np.array([0.01, -0.02, 0.0])
    road = Trace({"distance_m": known[0], "slope": known[1]})
    (tmp_path / "road.csv").write_text(
        "distance_m,slope\n"
        + "".join(f"{s},{k}\n" for s, k in zip(*road.columns.values(), strict=True))
    )
    text = load_vehicle("r1t_epa").path.read_text()
    (tmp_path / "car.toml").write_text(
        f'{text}\n[effects.road_grade]\nslope = 0.003\nprofile = "road.csv"\n'
    )
    car = load_vehicle(str(tmp_path / "car.toml"))
    found = hill(600, 0.02, mean=0.004)
    mended = tmp_path / "mended.toml"
    write_mended(diagnosis(car, [problem(car, 60.0)], {0: found}), mended)
    out = load_vehicle(str(mended))
    s = np.linspace(0, 600, 31)
    total = np.interp(s, *road_of(out)) + out.figures()[SLOPE].value
    assert total == pytest.approx(0.003 + np.interp(s, *known) + found.at(s), abs=1e-6)


def test_a_mended_file_that_is_refused_leaves_all_as_it_was(tmp_path, monkeypatch):
    car = load_vehicle("r1t_epa")
    found = diagnosis(car, [problem(car, 60.0)], {0: hill(600, 0.02)})
    beside, mended = tmp_path / "mended.road_grade.csv", tmp_path / "mended.toml"

    def refused(*_):
        assert "distance_m" in beside.read_text()
        raise InputError("the disk is full")

    monkeypatch.setattr("rcc_sim.diagnose.deliver.write_vehicle", refused)
    for before in (None, "an earlier road\n"):
        if before:
            beside.write_text(before)
        with pytest.raises(InputError, match="the disk is full"):
            write_mended(found, mended)
        assert not mended.exists()
        assert (beside.read_text() if beside.exists() else None) == before
        assert len(list(tmp_path.iterdir())) == bool(before)


def test_beyond_the_log_the_mended_road_is_the_stated_one(tmp_path):
    car = load_vehicle("r1t_epa")
    found = diagnosis(car, [problem(car, 60.0)], {0: hill(600, 0.02, mean=0.01)})
    write_mended(found, tmp_path / "mended.toml")
    mended = load_vehicle(tmp_path / "mended.toml")
    slope = np.interp([0.0, 150.0, 600.0, 750.0, 5000.0], *road_of(mended))
    slope += mended.figures()[SLOPE].value
    assert slope == pytest.approx([0.01, 0.03, 0.01, 0.0, 0.0], abs=1e-9)


def test_the_mended_road_is_the_one_that_was_fitted_where_the_speeds_are_off(tmp_path):
    car = load_vehicle("r1t_epa")
    one, found = problem(car, 60.0), hill(700, 0.03)
    told = diagnosis(car, [one], {0: found})
    of = {"road_grade": {"slope": Figure(0.0, 0.006)}}
    told.effects = lambda: of | {"wheel_radius": {"scale": Figure(1.04, 0.002)}}
    write_mended(told, tmp_path / "mended.toml")
    mended = load_vehicle(tmp_path / "mended.toml")
    rolled = car.changed(settings={"effects.wheel_radius.scale": 1.04})
    fitted = replay(rolled, one.on_road(found.knots, found.value).drive)
    power = replay(mended, drive_of(one.log, mended))["battery_power_w"]
    assert power == pytest.approx(fitted["battery_power_w"], rel=1e-3, abs=1.0)


def test_no_bag_is_written_of_what_a_speed_drives(tmp_path):
    """Asked again where it is written: a table in a file of that name is no bag."""
    imposed = problem(load_vehicle("r1t_epa"), 60.0)
    for asked in (tmp_path / "n.csv", tmp_path / "n"):
        refuse_bag(asked, lambda: imposed)
    with pytest.raises(InputError, match="where speed_mps is what is driven"):
        refuse_bag(tmp_path / "n.mcap", lambda: imposed)
