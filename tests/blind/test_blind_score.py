"""`blind run` without labels, `blind score` with them: the arithmetic, by hand."""

from __future__ import annotations

import json
import os
import subprocess
import threading
from math import nan

import numpy as np
import pytest

from rcc_sim.blind import measures
from rcc_sim.blind.answers import alike, answer
from rcc_sim.blind.make import make
from rcc_sim.blind.run import Killed, NoAnswer, rccsim, read_results, run
from rcc_sim.blind.score import failures, figures, score
from rcc_sim.blind.seal import write_seal
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import CheckFailed, InputError
from tests import program


def cause(effect, p=0.9, **parameters):
    figures = {
        k: {"value": v, "low": lo, "high": hi} for k, (v, lo, hi) in parameters.items()
    }
    return {"effect": effect, "probability": p, "parameters": figures}


def label(kind, magnitudes=None, **more):
    magnitudes = magnitudes or {}
    effects = [] if kind == "unknown" else list(magnitudes)
    return {
        "family": "rc",
        "kind": kind,
        "effects": effects,
        "magnitudes": magnitudes,
    } | more


def by_chance(percent):
    return {"gap_by_chance_percent": percent}


def fresh(before, after):
    gap = {"energy": {"gap_percent": before}}
    return {"before": gap, "after": {"energy": {"gap_percent": after}}}


LABELS = {
    "a": label("single", {"payload": {"mass_kg": 1.0}}, fresh=by_chance(-3.7)),
    "b": label(
        "single", {"rolling_resistance": {"coefficient": 0.02}}, fresh=by_chance(4.1)
    ),
    "c": label("single", {"steering_gain": {"gain": 1.2}}),
    "d": label(
        "pair",
        {"payload": {"mass_kg": 1.0}, "copper_loss": {"phase_resistance_ohm": 0.03}},
    ),
    "e": label("null"),
    "f": label("null"),
    "g": label(
        "unknown",
        {"tyre_rub": {"rub_T": 0.01}},
        windows={"log": [[10.0, 20.0], [40.0, 50.0]]},
    ),
    "h": label(
        "unknown", {"lost_load": {"drop_m": 1.0}}, windows={"log": [[30.0, 75.0]]}
    ),
}
ANSWERS = {
    # right, 10 % off, interval holds the truth, gap gone
    "a": {"status": "explained",
          "causes": [cause("payload", 0.95, mass_kg=(1.1, 0.9, 1.2))]},
    # a member of the same group counts as right
    "b": {"status": "explained", "causes": [cause("drivetrain_friction", 0.6)]},
    # wrong; the truth is second in the ranking
    "c": {"status": "explained", "causes": [cause("steering_lag", 0.7)
                     | {"indistinguishable_from": ["steering_gain"]}],
          "ranking": [{"effect": "steering_gain"}]},
    "d": {"status": "partly_explained",
          "causes": [cause("payload", 0.9, mass_kg=(1.0, 1.01, 1.2))]},
    "e": {"status": "no_gap", "causes": []},
    "f": {"status": "explained", "causes": [cause("payload", 0.55)]},
    "g": {"status": "unexplained", "causes": [],
          "unexplained": {"windows": [{"start_s": 15.0, "end_s": 25.0}]}},
    "h": {"status": "partly_explained", "causes": [cause("payload", 0.8)]},
}  # fmt: skip
FRESH = {"a": fresh(12.0, 0.3), "b": fresh(-9.0, 4.0), "d": fresh(2.0, 1.9)}


@pytest.fixture
def scored(tmp_path):
    out = tmp_path / "cases"
    (out / "results").mkdir(parents=True)
    labels = tmp_path / "labels.json"
    write_seal(out, labels, {"schema": "rccsim.blind/1", "cases": LABELS})
    for name, diagnosis in ANSWERS.items():
        result = {"case": name, "error": "", "seconds": 2.0, "diagnosis": diagnosis}
        result["fresh"] = FRESH.get(name, {})
        (out / "results" / f"{name}.json").write_text(json.dumps(result))
    return out, labels


def test_shares_are_counted_as_by_hand(scored):
    shares = score(*scored)["shares"]
    counted = {k: (s["hits"], s["of"]) for k, s in shares.items()}
    assert counted == {
        "ran": (8, 8),
        "single_first": (2, 3),
        "single_in_three": (3, 3),
        "single_in_tie": (3, 3),
        "single_exact": (2, 3),
        "pair_exact": (0, 1),
        "pair_one": (1, 1),
        "null_quiet": (1, 2),
        "null_false_alarm": (1, 2),
        "unknown_admitted": (1, 2),
        "unknown_falsely_named": (1, 2),
        "interval_coverage": (1, 2),
        "fresh_energy_shrank": (1, 2),
        "fresh_energy_by_chance": (1, 2),
    }


def test_parameter_errors_shrink_and_windows_are_as_by_hand(scored):
    document = score(*scored)
    spreads = document["spreads"]
    assert spreads["parameter_error"]["median"] == pytest.approx(0.05)  # 0.1 and 0
    assert spreads["fresh_energy_after_percent"]["median"] == pytest.approx(1.9)
    assert spreads["fresh_energy_by_chance_percent"]["median"] == pytest.approx(3.9)
    assert spreads["seconds"]["median"] == 2.0
    # g: 5 s of 10 flagged are right; 5 of 20 found; 5 of 25 either. h flags nothing.
    rows = {row["case"]: row for row in document["rows"]}
    assert rows["g"]["where"] == pytest.approx(
        {"iou": 0.2, "precision": 0.5, "recall": 0.25, "chance": 20 / 75}
    )
    assert rows["h"]["where"]["recall"] == 0.0


def test_the_confusion_matrix_counts_each_single_null_and_unknown_once(scored):
    table = score(*scored)["confusion"]
    assert table["rolling_resistance"] == {"drivetrain_friction": 1}
    assert table["null"] == {"no_gap": 1, "payload": 1}
    assert table["lost_load"] == {"payload": 1}
    assert sum(sum(row.values()) for row in table.values()) == 7


def test_a_person_sees_the_whole_of_a_score(scored):
    from rcc_sim.blind.score import table

    rows = {row["figure"]: row for row in table(score(*scored))}
    assert rows["null -> payload"]["value"] == 1
    assert rows["rolling_resistance named"]["value"] == 1.0
    assert rows["right where said 0.9 to 1"]["of"] == 2
    low, high = rows["single_first"]["low_95"], rows["single_first"]["high_95"]
    assert (low, high) == pytest.approx(measures.Share(2, 3).interval)


def test_calibration_takes_every_claim_and_none_is_right_where_nothing_known_acts(
    scored,
):
    found = score(*scored)["calibration"]
    stated = [0.95, 0.6, 0.7, 0.9, 0.55, 0.8]
    right = [1, 1, 0, 1, 0, 0]
    assert found["n"] == 6
    assert found["brier"] == pytest.approx(np.mean((np.array(stated) - right) ** 2))


def test_a_gain_is_off_in_parts_of_its_departure_from_one(tmp_path):
    answered = {
        "diagnosis": {"causes": [cause("steering_gain", 1.0, gain=(1.15, 1.1, 1.3))]}
    }
    row = answer("c", LABELS["c"], answered, tmp_path)
    assert row["parameters"][0]["error"] == pytest.approx(0.25)
    assert row["parameters"][0]["covered"]


def test_effects_of_a_group_are_alike_and_others_are_not():
    assert alike("headwind", "aerodynamic_drag") and alike("payload", "payload")
    assert not alike("rolling_resistance", "iron_loss")
    assert not alike("road_grade", "headwind")


def test_a_bar_that_is_missed_is_an_exit_status(scored):
    out, labels = scored
    for bar, status in (
        ("single_first>=0.6", 0),
        ("single_first>=0.7", 1),
        ("x>=1", 2),
    ):
        words = "score", out, "--labels", labels, "--json", "--require", bar
        done = program.rccsim("blind", *words)
        assert done.returncode == status, done.stderr
        assert bool(done.stdout) == (status < 2)
        assert ("error: " in done.stderr) == (status > 0)


def test_bars_compare_every_way_and_none_is_reached_without_a_case(scored):
    document = score(*scored)
    bars = ["null_false_alarm<=0.5", "null_false_alarm<0.5", "ran>0.99", "ran>1"]
    assert [m.split()[0] for m in failures(document, bars)] == [
        "null_false_alarm",
        "ran",
    ]
    with pytest.raises(InputError, match="KEY>=VALUE"):
        failures(document, ["ran=1"])
    document["shares"]["ran"]["value"] = nan
    assert failures(document, ["ran>=0"])
    assert "calibration_ece" in figures(document)


def test_labels_that_were_touched_are_not_scored(scored):
    out, labels = scored
    labels.write_text(labels.read_text().replace('"payload"', '"copper_loss"', 1))
    with pytest.raises(CheckFailed, match="SHA-256"):
        score(out, labels)


def test_run_needs_no_labels_and_shows_the_diagnosis_neither_labels_nor_fresh(tmp_path):
    out = tmp_path / "cases"
    seal = make(out, cases=2, seed=4, families=["rc"])
    os.unlink(seal.labels)
    seen = []

    def command(words, folder):
        seen.append((words[0], sorted(p.name for p in folder.iterdir())))
        if words[0] == "diagnose":
            (folder / "fixed.toml").write_text((folder / "vehicle.toml").read_text())
            return {"status": "no_gap", "causes": []}
        return {"energy": {"gap_percent": 0.1}, "channels": []}

    lines = list(run(out, command=command))
    assert [line["status"] for line in lines] == ["no_gap", "no_gap"]
    looks = [names for word, names in seen if word == "diagnose"]
    assert looks == [["log.csv.gz", "vehicle.toml"]] * 2
    assert read_results(out)["c0000"]["fresh"]["after"]["energy"]["gap_percent"] == 0.1
    seen.clear()
    assert list(run(out, command=command)) == [] and seen == []  # goes on, not again
    assert len(list(run(out, command=command, again=True, only=["c0001"]))) == 1


def test_a_case_that_fails_is_counted_as_not_run_and_ends_nothing(tmp_path):
    out = tmp_path / "cases"
    seal = make(out, cases=2, seed=4, families=["rc"])

    def command(words, folder):
        raise NoAnswer("error: it broke")

    assert [line["error"] for line in run(out, command=command)] == [
        "error: it broke"
    ] * 2
    document = score(out, seal.labels)
    assert document["shares"]["ran"]["hits"] == 0
    assert document["shares"]["single_first"]["hits"] == 0


def test_a_case_that_was_killed_is_done_next_time_and_stops_no_other(tmp_path):
    out = tmp_path / "cases"
    make(out, cases=2, seed=4, families=["rc"])
    killed = {"c0000"}

    def command(words, folder):
        name = load_vehicle(folder / "vehicle.toml").name
        if name in killed:
            killed.remove(name)
            raise Killed("ended from outside (-9)")
        return {"status": "no_gap", "causes": []}

    lines = {line["case"]: line for line in run(out, command=command)}
    assert lines["c0000"]["status"] == "killed"
    assert sorted(line["done"] for line in lines.values()) == [1, 2]
    assert list(read_results(out)) == ["c0001"]
    assert [line["case"] for line in run(out, command=command)] == ["c0000"]
    assert sorted(read_results(out)) == ["c0000", "c0001"]


def test_a_command_that_a_signal_ends_gives_no_answer_to_keep(tmp_path, monkeypatch):
    ended = subprocess.CompletedProcess([], -9, "", "")
    monkeypatch.setattr(subprocess, "run", lambda *a, **k: ended)
    with pytest.raises(Killed):
        rccsim(["diagnose"], tmp_path)


def test_lines_come_as_cases_are_done_and_not_in_their_order(tmp_path):
    out = tmp_path / "cases"
    make(out, cases=2, seed=4, families=["rc"])
    quick = threading.Event()

    def command(words, folder):
        if load_vehicle(folder / "vehicle.toml").name == "c0000":
            assert quick.wait(30)
        return {"status": "no_gap", "causes": []}

    seen = []
    for line in run(out, jobs=2, command=command):
        seen.append(line["case"])
        quick.set()
    assert seen == ["c0001", "c0000"]


def test_wilsons_interval_is_the_published_one():
    """Newcombe, Stat. Med. 17 (1998) 857, table I, method 3."""
    published = {
        (81, 263): (0.2553, 0.3662),
        (15, 148): (0.0624, 0.1605),
        (0, 20): (0.0, 0.1611),
        (1, 29): (0.0061, 0.1718),
    }
    for (hits, of), interval in published.items():
        assert measures.Share(hits, of).interval == pytest.approx(interval, abs=6e-5)


def test_stated_probabilities_that_come_true_have_no_calibration_error():
    stated = [0.25] * 8 + [0.75] * 8
    right = [1, 1] + [0] * 6 + [1] * 6 + [0, 0]
    found = measures.calibration(stated, right)
    assert found["ece"] == pytest.approx(0.0)
    assert found["brier"] == pytest.approx(0.25 * 0.75)
    assert measures.calibration([1.0] * 4, [1, 0, 0, 0])["ece"] == pytest.approx(0.75)


def test_spans_that_overlap_count_once():
    assert measures.length([(0, 2), (1, 3), (5, 6)]) == 4.0
    assert measures.common([(0, 2), (1, 4)], [(3, 10)]) == 1.0
    full = measures.overlap([(0, 4)], [(0, 4)], 8.0)
    assert full == {"iou": 1.0, "precision": 1.0, "recall": 1.0, "chance": 0.5}


def test_a_profile_twice_as_steep_and_shifted_has_slope_two_and_that_bias():
    true = np.sin(np.linspace(0, 20, 400))
    found = measures.agreement(2 * true + 0.5, true)
    assert found["correlation"] == pytest.approx(1.0)
    assert found["slope"] == pytest.approx(2.0)
    assert found["bias"] == pytest.approx(0.5 + true.mean())


def test_profiles_are_compared_over_time_and_over_distance(tmp_path):
    out = tmp_path
    (out / "results").mkdir()
    (out / "p").mkdir()
    t = np.arange(0.0, 100.0, 0.1)
    log = "time_s,speed_mps\n" + "".join(f"{x:.1f},10.0\n" for x in t)
    (out / "p" / "log.csv.gz").write_bytes(__import__("gzip").compress(log.encode()))
    s = np.arange(0.0, 1000.0, 5.0)
    slope, power = 0.01 * np.sin(s / 60.0), np.where(np.arange(101) < 50, 800.0, 300.0)
    profiles = {
        "road_grade.slope": {"distance_m": s.tolist(), "value": slope.tolist()},
        "auxiliary_load.power_w": {"time_s": list(range(101)), "value": power.tolist()},
    }
    held = np.interp(10.0 * t, s, slope)
    heat = np.interp(t, np.arange(101), power) + 20.0
    lines = ["time_s,road_grade.slope,auxiliary_load.power_w"]
    lines += [f"{a:.1f},{b:.8f},{c:.4f}" for a, b, c in zip(t, held, heat, strict=True)]
    (out / "results" / "p.profiles.csv").write_text("\n".join(lines) + "\n")
    truth = label("single", {"road_grade": {"slope_std": 0.01}}, profiles=profiles)
    found = answer("p", truth, {"diagnosis": {"causes": []}}, out)["profiles"]
    assert found["road_grade.slope"]["correlation"] == pytest.approx(1.0, abs=1e-3)
    assert found["road_grade.slope"]["slope"] == pytest.approx(1.0, abs=1e-3)
    assert found["auxiliary_load.power_w"]["bias"] == pytest.approx(20.0, abs=0.1)
