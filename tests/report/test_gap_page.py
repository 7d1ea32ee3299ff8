"""A gap as a page."""

from __future__ import annotations

import json
from itertools import pairwise

import numpy as np
import pytest

from rcc_sim.analyse.gap import Gap
from rcc_sim.analyse.gap_channels import ChannelGap
from rcc_sim.analyse.gap_energy import EnergyGap
from rcc_sim.analyse.gap_regimes import RegimeGap
from rcc_sim.analyse.gap_stages import StageGap
from rcc_sim.analyse.gap_windows import Window
from rcc_sim.report.findings import spans_of
from rcc_sim.report.gap_page import gap_page
from rcc_sim.report.html import page
from rcc_sim.report.text import figures
from rcc_sim.trace import Trace
from tests.program import rccsim


@pytest.fixture
def gap():
    time = np.arange(0.0, 100.0, 0.1)
    power = np.full(len(time), 36.0)
    return Gap(
        "drive.csv",
        "rcc",
        "commanded",
        EnergyGap("battery", 1.0, 0.8, noise_wh=0.03, tolerance_wh=0.04),
        (ChannelGap("battery_power_w", 1000, 7.2, 7.2, 0.1, "guess", 0.2, None, 0.5),),
        (
            RegimeGap("corner_mid", 60.0, 0.15, 0.75),
            RegimeGap("coast", 40.0, None, None),
        ),
        (StageGap("mechanical", 0.2, 1.0),),
        (Window(12.0, 20.5, "battery_power_w", 0.4),),
        (),
        ("noise is guessed from the log",),
        np.where(time < 60, 7, 4),
        Trace({"time_s": time, "battery_power_w": power}, name="drive.csv"),
        {"battery_power_w": 0.8 * power},
    )


def test_a_gap_has_its_verdict_doubt_and_place_on_the_page(gap):
    text = page(gap_page(gap)).replace("&nbsp;", " ")
    for words in (
        "the model misses 20 % (1 Wh against 0.8 Wh)",
        "more than what noise",
        "± 0.1 Wh",
        "corner mid",
        "mechanical",
        "12 to 20.5",
        "noise is guessed from the log",
        "simulated",
    ):
        assert words in text
    assert "simulated before" not in text  # there is no after


@pytest.mark.slow
def test_gap_writes_its_page_from_the_command_line(tmp_path):
    def run(*words):
        done = rccsim(*words, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout

    rolls = ("--with", "rolling_resistance:coefficient=0.02")
    run("simulate", "rcc", "--cycle", "udds[20:60]", *rolls, "-o", "log.csv")
    told = run("gap", "log.csv", "--vehicle", "rcc", "--html", "gap.html", "--json")
    energy = json.loads(told)["energy"]
    text = (tmp_path / "gap.html").read_text("utf-8").replace("&nbsp;", " ")
    assert f"{figures(energy['measured_wh'], 4)}" in text
    assert f"the model misses {figures(energy['gap_percent'])} %" in text
    assert "rccsim gap log.csv --vehicle rcc --html gap.html --json" in text


def test_spans_cover_the_log_once_and_name_each_row():
    time = np.arange(0.0, 100.0, 0.1)
    kinds = np.repeat([0, 2, 1, 2], 250)
    spans = spans_of(time, kinds, ("a_b", "c", "d"))
    assert [s.name for s in spans] == ["a b", "d", "c", "d"]
    assert (spans[0].start_s, spans[-1].end_s) == (time[0], time[-1])
    assert all(a.end_s == b.start_s for a, b in pairwise(spans))


def test_a_regime_too_short_to_see_joins_the_one_before():
    time = np.arange(0.0, 1000.0, 0.1)
    kinds = np.zeros(len(time), dtype=int)
    kinds[5000] = 1
    assert [s.name for s in spans_of(time, kinds, ("long", "short"))] == ["long"]
