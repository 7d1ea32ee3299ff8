"""The shell completes vehicles, cycles, effects, figures and a log's own columns."""

from __future__ import annotations

import gzip
import os
import shlex
import subprocess
import sys

import pytest

from tests.program import rccsim

HEADER = "time_s,speed_mps,battery_voltage_v,battery_current_a,\x1b[31mred_w"


@pytest.fixture(scope="module")
def bash(tmp_path_factory):
    """Return what bash would offer, by the script that --install-completion writes."""
    home = tmp_path_factory.mktemp("home")
    tool = home / "rccsim"
    tool.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m rcc_sim "$@"\n')
    tool.chmod(0o755)
    row = "0,1,2,3,4\n"
    (home / "log.csv").write_text(f"{HEADER}\n{row}", encoding="utf-8")
    with gzip.open(home / "log.csv.gz", "wt", encoding="utf-8") as file:
        file.write(f"{HEADER}\n{row * 100_000}")
    (home / "other.csv").write_text("time_s;accel_x_mps2\n0;1\n")
    (home / "far.csv").write_text("Time [s],Velocity [km/h],Motor Torque [Nm]\n0,1,2\n")
    env = os.environ | {
        "PATH": f"{home}{os.pathsep}{os.environ['PATH']}",
        "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1",
    }

    def offered(line):
        words = [*shlex.split(line), *([""] if line.endswith(" ") else [])]
        script = (
            'eval "$(rccsim --show-completion bash)"\n'
            f"COMP_WORDS=({' '.join(map(shlex.quote, words))})\n"
            f"COMP_CWORD={len(words) - 1}\n"
            '_rccsim_completion rccsim\nprintf "%s\\n" "${COMPREPLY[@]}"\n'
        )
        done = subprocess.run(
            ["bash", "-c", script], capture_output=True, text=True, env=env, cwd=home
        )
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout.split()

    return offered


@pytest.mark.parametrize(
    ("line", "offers"),
    [
        ("rccsim diag", ["diagnose"]),
        ("rccsim gap log.csv --vehicle r1", ["r1t", "r1t_epa"]),
        ("rccsim match rcc --to r1t_", ["r1t_epa"]),
        ("rccsim motor-map rcc --against r1t_", ["r1t_epa"]),
        ("rccsim simulate rcc --cycle ud", ["udds"]),
        ("rccsim simulate rcc --with gear", ["gear_loss"]),
        ("rccsim simulate rcc --set body.ma", ["body.mass_kg"]),
        ("rccsim sweep rcc --set tyres.ra", ["tyres.radius_m"]),
        ("rccsim simulate rcc --without copp", ["copper_loss"]),
        ("rccsim simulate rcc --without rolling", []),  # rcc has none
        ("rccsim plot effect wheel", ["wheel_radius"]),
        ("rccsim convert log.csv --map vesc", ["vesc_tool"]),
    ],
)
def test_bash_offers_what_there_is(bash, line, offers):
    assert bash(line) == offers


@pytest.mark.parametrize(
    "line",
    [
        "rccsim gap log.csv --hide battery_",
        "rccsim gap log.csv.gz --hide battery_",
        "rccsim diagnose log.csv --vehicle rcc --hide battery_",
        "rccsim plot run log.csv --column battery_",
    ],
)
def test_columns_are_those_of_the_log_on_the_line(bash, line):
    assert bash(line) == ["battery_voltage_v", "battery_current_a"]


def test_columns_of_several_logs_are_offered_together(bash):
    told = bash("rccsim diagnose log.csv other.csv --hide ")
    assert {"speed_mps", "accel_x_mps2"} <= set(told) and "time_s" not in told


def test_a_column_with_an_escape_sequence_is_not_offered(bash):
    assert not [c for c in bash("rccsim gap log.csv --hide ") if "\x1b" in c]


def test_a_foreign_log_offers_the_names_that_its_map_gives(bash):
    told = bash("rccsim gap far.csv --map bmw_i3_tum --hide motor_")
    assert told == ["motor_torque_nm"]


@pytest.mark.parametrize("name", ["missing.csv", "-", "log.bag"])
def test_a_log_that_cannot_be_read_offers_nothing(bash, name):
    assert bash(f"rccsim gap {name} --hide ") == []


def test_plot_draws_the_columns_asked_for_and_refuses_others(tmp_path):
    (tmp_path / "a.csv").write_text("time_s,aux_power_w\n0,1\n1,2\n2,5\n")

    def run(*words):
        return rccsim("plot", "run", "a.csv", *words, cwd=tmp_path)

    done = run("--column", "aux_power_w", "-o", "a.svg")
    assert done.returncode == 0, done.stderr
    assert "Auxiliary power [W]" in (tmp_path / "a.svg").read_text()
    wrong = run("--column", "nonsense_w")
    assert (
        wrong.returncode == 2 and "nonsense_w: a.csv does not have it" in wrong.stderr
    )
