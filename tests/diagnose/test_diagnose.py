"""The diagnosis on drives of the plant, which shares no code with the model."""

import ast
import json
from pathlib import Path

import numpy as np
import pytest

import rcc_sim.diagnose
from rcc_sim.analyse.logged import open_log
from rcc_sim.blind.make import make
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.deliver import write_mended
from rcc_sim.diagnose.run import diagnose

TIES = (
    {"rolling_resistance", "drivetrain_friction", "road_grade"},
    {"drivetrain_damping", "iron_loss"},
    {"aerodynamic_drag", "headwind"},
)


def alike(a, b):
    return a == b or any(a in tie and b in tie for tie in TIES)


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    out = tmp_path_factory.mktemp("diagnosed") / "cases"
    seal = make(out, cases=6, seed=5, families=("ev",))
    labels = json.loads(seal.labels.read_text())["cases"]
    seal.labels.unlink()  # the diagnosis has to do without
    return out, labels


def found_in(case, candidates=()):
    vehicle = load_vehicle(case / "vehicle.toml")
    log = open_log(case / "log.csv.gz", vehicle)
    return diagnose([log], vehicle, candidates=candidates)


@pytest.fixture(scope="module")
def diagnoses(cases):
    out, labels = cases
    return {name: found_in(out / name) for name in labels}


@pytest.mark.slow
def test_most_withheld_effects_are_named_and_no_null_is_blamed(cases, diagnoses):
    _, labels = cases
    right = [
        any(alike(a.cause.effect, t) for t in labels[n]["effects"])
        for n, d in diagnoses.items()
        for a in d.asserted[:1]
        if labels[n]["kind"] in ("single", "pair")
    ]
    named = [n for n, d in diagnoses.items() if d.asserted]
    acted = [n for n in labels if labels[n]["kind"] in ("single", "pair")]
    assert sum(right) >= 0.7 * len(acted)
    nulls = [n for n in labels if labels[n]["kind"] == "null"]
    assert not set(nulls) & set(named)


@pytest.mark.slow
def test_the_document_holds_the_contract(diagnoses):
    for found in diagnoses.values():
        document = json.loads(json.dumps(found.document(), default=float))
        assert document["schema"] == "rccsim.diagnosis/1"
        assert document["status"] in (
            "no_gap",
            "explained",
            "partly_explained",
            "unexplained",
        )
        assert (document["status"] in ("no_gap", "unexplained")) == (
            not document["causes"]
        )
        chances = [row["probability"] for row in document["ranking"]]
        assert all(0 <= p <= 1 for p in chances)
        for cause in document["causes"]:
            for figure in cause["parameters"].values():
                assert figure["low"] <= figure["value"] <= figure["high"]
        assert document["shrink"]["low"] <= document["shrink"]["explained"]
        assert document["shrink"]["explained"] <= document["shrink"]["high"]


@pytest.mark.slow
def test_the_mended_vehicle_comes_nearer_on_a_drive_that_was_not_fitted(
    cases, diagnoses, tmp_path
):
    from rcc_sim.analyse.gap import gap

    out, labels = cases
    tried = 0
    for name, found in diagnoses.items():
        if not found.asserted or labels[name]["kind"] not in ("single", "pair"):
            continue
        write_mended(found, tmp_path / f"{name}.toml")
        mended = load_vehicle(tmp_path / f"{name}.toml")
        gaps = []
        for vehicle in (found.vehicle, mended):
            log = open_log(out / name / "fresh.csv.gz", vehicle)
            gaps.append(abs(gap(log, vehicle).energy.gap_percent))
        tried += 1
        assert gaps[1] < max(1.5, gaps[0])
    assert tried > 0


def test_nothing_in_the_diagnosis_reads_a_label():
    folder = Path(rcc_sim.diagnose.__file__).parent
    modules_of_it = sorted(folder.rglob("*.py"))
    assert len(modules_of_it) > 50  # all floors, and not the topmost alone
    for path in modules_of_it:
        tree = ast.parse(path.read_text("utf-8"))
        words = [
            node.value
            for node in ast.walk(tree)
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        ]
        assert not [w for w in words if "labels" in w and "\n" not in w]
        modules = [
            node.module or ""
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
        ]
        assert not [m for m in modules if m.startswith("rcc_sim.blind")]


@pytest.mark.slow
def test_names_of_files_do_not_reach_the_diagnosis(cases, tmp_path):
    out, labels = cases
    name = next(n for n, label in labels.items() if label["kind"] == "single")
    other = tmp_path / "rolling_resistance_null_unknown"
    other.mkdir()
    for file in (out / name).iterdir():
        (other / file.name).write_bytes(file.read_bytes())
    few = (*labels[name]["effects"], "rolling_resistance", "headwind")
    first, again = found_in(out / name, few), found_in(other, few)
    assert first.status == again.status
    assert first.fit.values == again.fit.values
    assert np.isclose(
        first.proof.shrink.explained, again.proof.shrink.explained, atol=0
    )
