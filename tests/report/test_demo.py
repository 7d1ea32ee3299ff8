"""The demo does the main job and ends with the path of its report."""

import csv
import subprocess
import sys

import pytest


def shown(folder):
    command = [sys.executable, "-m", "rcc_sim", "demo"]
    run = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    assert run.returncode == 0, run.stderr
    return run


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shown")
    return folder, shown(folder)


@pytest.mark.slow
def test_the_demo_ends_with_the_path_of_the_page_it_wrote(done):
    folder, run = done
    path = run.stderr.splitlines()[-1].rpartition(" ")[2]
    assert path == "demo/diagnosis.html"
    assert run.stdout.splitlines()[-1] == f"report,{path},"
    text = (folder / path).read_text("utf-8")
    assert "Where the watt-hours went" in text and "What gives it away" in text
    assert len(text) < 6e6


@pytest.mark.slow
def test_the_demo_finds_what_was_sealed_and_mends_another_drive(done):
    rows = {r["what"]: r for r in csv.DictReader(done[1].stdout.splitlines())}
    found = rows["cause found"]["value"]
    sealed = float(rows[f"{found} sealed, opened now"]["value"])
    assert float(rows[f"{found} found"]["value"].split()[0]) == pytest.approx(
        sealed, rel=0.1
    )
    before, after = (
        float(rows[f"another drive, gap {when}"]["value"])
        for when in ("before", "with the mended vehicle")
    )
    assert abs(after) < abs(before) / 3


@pytest.mark.slow
def test_every_command_that_the_demo_prints_is_a_command(done):
    from rcc_sim.cli.app import command_names

    told = [line.split() for line in done[1].stderr.splitlines()]
    words = [w[1] for w in told if w[:1] == ["rccsim"]]
    assert len(words) == 7 and set(words) <= set(command_names())


@pytest.mark.thorough
def test_a_second_demo_takes_the_place_of_the_first(done):
    folder, first = done
    assert shown(folder).stdout == first.stdout
