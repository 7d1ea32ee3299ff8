"""`blind make`: sealed, the same for the same seed, and cases as they should be."""

from __future__ import annotations

import hashlib
import json

import numpy as np
import pytest

from rcc_sim.analyse.gap_channels import refuse_other_drives
from rcc_sim.blind import bases, drives, worth
from rcc_sim.blind.case import make_case
from rcc_sim.blind.label import acting
from rcc_sim.blind.make import make
from rcc_sim.blind.own import base_of
from rcc_sim.blind.seal import opened
from rcc_sim.blind.sensors import SENSORS
from rcc_sim.blind.strengths import draws
from rcc_sim.blind.unknowns import UNKNOWNS
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import CheckFailed, InputError
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import read_trace
from tests.program import rccsim


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    out = tmp_path_factory.mktemp("blind") / "cases"
    return out, make(out, cases=6, seed=11)


def content(folder):
    return {
        str(p.relative_to(folder)): p.read_bytes()
        for p in sorted(folder.rglob("*"))
        if p.is_file()
    }


def test_the_seal_is_the_hash_of_labels_that_lie_outside(made):
    out, seal = made
    data = seal.labels.read_bytes()
    assert hashlib.sha256(data).hexdigest() == seal.sha256
    assert not seal.labels.is_relative_to(out)
    assert json.loads((out / "seal.json").read_text())["sha256"] == seal.sha256


def test_nothing_among_the_cases_tells_a_label(made):
    out, seal = made
    names = {"vehicle.toml", "log.csv.gz", "fresh.csv.gz"}
    for case in seal.cases:
        assert {p.name for p in (out / case).iterdir()} == names
    sealed = json.loads((out / "seal.json").read_text())
    assert sealed.keys() == {"schema", "sha256", "cases"}  # and not the seed


def test_labels_that_were_changed_are_refused(made, tmp_path):
    out, seal = made
    other = tmp_path / "labels.json"
    other.write_text(seal.labels.read_text().replace("null", "pair", 1) + " ")
    with pytest.raises(CheckFailed, match="SHA-256"):
        opened(out, other)
    assert sorted(opened(out, seal.labels)["cases"]) == seal.cases


def test_the_same_seed_gives_the_same_bytes_with_any_number_of_jobs(made, tmp_path):
    out, seal = made
    again = make(tmp_path / "again", cases=6, seed=11, jobs=2)
    assert again.sha256 == seal.sha256
    assert content(tmp_path / "again") == content(out)


def test_repeats_are_the_same_drive_on_another_lane(made, tmp_path):
    out, _ = made
    again = make(tmp_path / "again", cases=2, seed=11, repeats=2)
    names = {"vehicle.toml", "log.csv.gz", "fresh.csv.gz"}
    for case in again.cases:
        there = content(tmp_path / "again" / case)
        assert content(out / case).items() <= there.items()
        repeats = {"repeat1.csv.gz", "repeat2.csv.gz"}
        assert there.keys() == names | repeats
        log, *others = (
            read_trace(str(tmp_path / "again" / case / name))
            for name in ("log.csv.gz", *sorted(repeats))
        )
        refuse_other_drives(log, others)
        known = [x for x in ("speed_ref_mps", "steer_cmd_rad") if x in log]
        for other in others:
            for name in known:
                then = np.interp(log["time_s"], other["time_s"], other[name])
                assert np.max(np.abs(then - log[name])) < 0.1 * np.ptp(log[name])
            at = other["time_s"], other["accel_x_mps2"]
            assert np.std(np.interp(log["time_s"], *at) - log["accel_x_mps2"]) > 0.05


def test_more_cases_leave_those_before_as_they_are(made, tmp_path):
    out, _ = made
    fewer = make(tmp_path / "fewer", cases=2, seed=11)
    for case in fewer.cases:
        assert content(tmp_path / "fewer" / case) == content(out / case)


def test_another_seed_gives_other_cases(made, tmp_path):
    out, _ = made
    make(tmp_path / "other", cases=1, seed=12)
    assert content(tmp_path / "other" / "c0000") != content(out / "c0000")


def test_every_case_reads_as_a_users_file_and_log(made):
    out, seal = made
    for case in seal.cases:
        vehicle = load_vehicle(out / case / "vehicle.toml")
        for part in ("log", "fresh"):
            log = read_trace(str(out / case / f"{part}.csv.gz"))
            assert np.all(np.diff(log["time_s"]) > 0)
            assert log["speed_mps"].max() > 1.0
            assert ("speed_ref_mps" in log) == (vehicle.controller.mode == "speed")


def test_a_withheld_effect_is_missing_from_the_file(made):
    out, seal = made
    for case, label in opened(out, seal.labels)["cases"].items():
        vehicle = load_vehicle(out / case / "vehicle.toml")
        stated = set(vehicle.effects) & set(label["effects"])
        assert stated <= {"auxiliary_load", "reference_sampling"}  # stated too small


def test_every_effect_that_acts_is_worth_thirty_nats(made):
    out, seal = made
    labels = opened(out, seal.labels)["cases"].values()
    worths = [n for lb in labels for n in lb["nats_beyond_tolerances"].values()]
    assert worths and min(worths) >= 30.0


@pytest.mark.parametrize("kind, count", [("null", 0), ("pair", 2), ("single", 1)])
def test_a_kind_has_as_many_effects_as_it_says(kind, count):
    case = make_case("c", kind, np.random.default_rng(5), ["rc"])
    assert len(case.label["effects"]) == count
    assert set(case.label["effects"]) <= set(draws("rc"))


def test_an_unknown_has_windows_within_the_drive_and_no_effect():
    label = make_case("c", "unknown", np.random.default_rng(6), ["rc"]).label
    assert label["effects"] == [] and set(label["magnitudes"]) <= set(UNKNOWNS)
    spans = np.array(label["windows"]["log"])
    assert len(spans) and np.all(spans[:, 1] > spans[:, 0])
    assert spans.min() >= -0.01 and spans.max() <= 75.0


def test_stated_figures_are_off_by_their_stated_sds():
    rng = np.random.default_rng(1)
    car = bases.BASES[0]
    off = []
    for _ in range(400):
        file, sds, pulls = bases.stated(car, rng)
        off.append((file.m - car.m) / (bases.TOLERANCES["m"] * car.m))
        assert sds["m"] == pytest.approx(bases.TOLERANCES["m"] * file.m)
        assert off[-1] == pytest.approx(pulls["m"])
    assert np.std(off) == pytest.approx(1.0, abs=0.15)
    assert np.mean(off) == pytest.approx(0.0, abs=0.2)


def test_rough_road_has_the_spread_and_memory_that_were_asked_for():
    x = drives.rough_road(400_000, 0.03, 0.5, np.random.default_rng(2))
    assert x.std() == pytest.approx(0.03, rel=0.05)
    lag = round(0.5 / 0.01)
    assert np.mean(x[lag:] * x[:-lag]) / x.var() == pytest.approx(np.exp(-1), abs=0.05)


def test_gusts_have_the_spread_and_memory_that_were_asked_for():
    x = drives.gusts(200_000, 3.0, 20.0, np.random.default_rng(2))
    assert x.std() == pytest.approx(3.0, rel=0.05)
    assert np.mean(x[20:] * x[:-20]) / x.var() == pytest.approx(np.exp(-1), abs=0.05)


def test_a_road_that_turns_has_the_wind_from_ahead_and_from_behind():
    x = drives.turned(600, 5.0, 100.0, np.random.default_rng(2))
    assert set(np.unique(x)) == {-5.0, 5.0}
    legs = np.diff(np.flatnonzero(np.diff(x)))
    assert len(legs) >= 3 and legs.min() >= 50 and legs.max() <= 150


def test_worth_is_that_of_a_matched_filter_in_white_noise():
    """Half the energy of the change over the noise's variance; none if tolerated."""
    n = 6000
    car = bases.BASES[2]
    road = drives.Road(np.zeros(2), np.zeros(1), np.zeros(1), 0.0, 1.0)
    rng = np.random.default_rng(3)
    d, _ = drives.drive(car, road, "urban", rng)
    p = bases.truth(car, car.r_w)
    rule = worth.Yardstick("ev", p, d, ["m"], np.zeros((n, worth.COLUMNS)))
    change = np.zeros((n, worth.COLUMNS))
    noise = SENSORS["ev"]["battery_voltage_v"].noise
    change[:, 5] = 0.05 * np.sin(2 * np.pi * 40 * np.arange(n) / n)
    assert rule.nats(change) == pytest.approx(
        0.5 * n * 0.05**2 / 2 / noise**2, rel=1e-3
    )
    heavier = worth.coarse(bases.shifted(p, "m", bases.TOLERANCES["m"]), d, "ev")
    one_sd = heavier - rule.nominal
    assert rule.nats(one_sd) < 0.5  # as likely as any car within its tolerance
    assert rule.nats(change, [change]) == pytest.approx(0.0, abs=1e-3)
    slower = np.zeros((n, worth.COLUMNS))
    slower[:, SENSORS["ev"]["speed_mps"].place] = 0.1
    assert rule.nats(slower) == 0.0  # what drives the model is no witness


def test_acting_spans_are_where_the_activity_is():
    time = np.arange(0.0, 10.0, 0.01)
    activity = np.where((time > 2) & (time < 3), 1.0, 0.0)
    activity[(time > 7) & (time < 7.5)] = 0.5
    spans = acting(time, activity)
    assert np.ravel(spans) == pytest.approx([2.0, 3.0, 7.0, 7.5], abs=0.02)


def test_a_users_own_vehicle_is_drawn_around(tmp_path):
    base = base_of("rcc")
    rcc = load_vehicle("rcc")
    assert (base.m, base.family) == (rcc.body.mass_kg.value, "rc")
    seal = make(tmp_path / "own", cases=1, seed=1, kinds=["null"], base=base)
    label = opened(tmp_path / "own", seal.labels)["cases"]["c0000"]
    assert label["base"] == "rcc"
    drawn = load_vehicle(tmp_path / "own" / "c0000" / "vehicle.toml")
    assert drawn.body.mass_kg.value == pytest.approx(base.m, rel=0.35)


def test_what_a_users_file_states_besides_acts_unless_it_is_withheld(tmp_path):
    """Its lag and its gear's loss are as stated, but in files that hide them."""
    more = {"steering_lag": "time_constant_s = 0.06", "gear_loss": "efficiency = 0.9"}
    tables = "".join(f"\n[effects.{k}]\n{v}\n" for k, v in more.items())
    mine = tmp_path / "mine.toml"
    mine.write_text(load_vehicle("rcc").path.read_text() + tables, encoding="utf-8")
    base, out = base_of(str(mine)), tmp_path / "own"
    seal = make(out, cases=3, seed=5, kinds=["single"], base=base, effects=[*more])
    labels = opened(out, seal.labels)["cases"]
    for name, label in labels.items():
        acts = label["effects"][0]
        drawn = load_vehicle(out / name / "vehicle.toml")
        assert set(more) - set(drawn.effects) == {acts}
        lag = drawn.figures().get("effects.steering_lag.time_constant_s")
        assert lag is None or lag.value == 0.06
    assert {label["effects"][0] for label in labels.values()} == set(more)


@pytest.mark.parametrize("name", ["bmw_i3", "r1t_epa", "tesla_model_3", "twizy"])
def test_a_car_of_known_efficiency_is_drawn_around(name, tmp_path):
    """Battery power is the shaft's by that efficiency, and the rest of the cars'."""
    base = base_of(name)
    seal = make(tmp_path / "own", cases=1, seed=2, kinds=["null"], base=base)
    assert opened(tmp_path / "own", seal.labels)["cases"]["c0000"]["base"] == name
    drawn = load_vehicle(tmp_path / "own" / "c0000" / "vehicle.toml")
    scale = drawn.figures()["effects.motor_efficiency.scale"]
    assert 1 - scale.value == pytest.approx(base.loss, rel=0.5)
    assert not {"copper_loss", "iron_loss"} & drawn.effects.keys()
    log = read_trace(tmp_path / "own" / "c0000" / "log.csv.gz")
    found = replay(drawn, drive_of(log, drawn))
    measured = log["battery_voltage_v"] * log["battery_current_a"]
    energy = np.nansum(found["battery_power_w"]) / np.nansum(measured)
    assert energy == pytest.approx(1.0, abs=0.15)


def test_single_losses_do_not_act_beside_an_efficiency():
    assert {"copper_loss", "iron_loss"} <= set(draws("ev"))
    assert not {"copper_loss", "iron_loss"} & set(draws("ev", lossy=True))


@pytest.mark.parametrize("name, times", [("twizy", 0.07), ("tesla_model_3", 1.0)])
def test_a_low_voltage_makes_resistances_small(name, times):
    """The share of the voltage that is lost stays, at a power that goes with mass."""
    assert base_of(name).sag == pytest.approx(times, rel=0.1)


@pytest.mark.parametrize(
    "words, says",
    [
        (["--kinds", "singel"], "singel"),
        (["--family", "boat"], "boat"),
        (["--cases", "0"], "at least 1"),
        (["--vehicle", "dart_jetracer"], "controller.mode"),
        (["--labels", "out/labels.json"], "among the cases"),
    ],
)
def test_what_cannot_be_made_is_one_error_line(words, says, tmp_path):
    done = rccsim("blind", "make", "out", *words, cwd=tmp_path)
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.startswith("error: ") and says in done.stderr
    assert "Traceback" not in done.stderr


def test_a_make_that_breaks_off_leaves_nothing(tmp_path):
    def stop(done):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make(tmp_path / "out", cases=2, seed=1, families=["rc"], done=stop)
    assert list(tmp_path.iterdir()) == []


def test_cases_are_never_mixed_with_what_is_there(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("keep")
    with pytest.raises(InputError, match="not an empty folder"):
        make(tmp_path / "out", cases=1, seed=1)
    assert (tmp_path / "out" / "mine.txt").read_text() == "keep"


WIND = "headwind.speed_mps"


def test_effects_that_are_asked_for_act_in_each_case(tmp_path):
    """Those that are younger than the seeds of stated draws are drawn only so."""
    asked = ["friction_brake", "regeneration_fade", "headwind"]
    kinds, out = ["single", "pair"], tmp_path / "asked"
    seal = make(out, cases=3, seed=5, kinds=kinds, effects=asked)
    labels = json.loads(seal.labels.read_text())
    assert labels["effects"] == asked
    for case in labels["cases"].values():
        assert case["family"] == "ev"  # a scaled car has no friction brakes
        assert set(case["effects"]) & set(asked)
        assert ("headwind" in case["effects"]) == (WIND in case["profiles"])
    with pytest.raises(InputError, match="--effects: none is called 'friction_brake'"):
        make(tmp_path / "rc", cases=1, seed=5, families=["rc"], effects=asked)


def test_a_late_reference_is_drawn_where_it_is_asked_for(tmp_path):
    seal = make(tmp_path / "late", cases=2, seed=5, kinds=["single"],
                effects=["reference_delay"])  # fmt: skip
    for case in json.loads(seal.labels.read_text())["cases"].values():
        assert (case["family"], case["effects"]) == ("rc", ["reference_delay"])
        (delay,) = case["magnitudes"]["reference_delay"].values()
        assert 0.04 <= delay <= 0.16
