"""What a terminal shows: bars that mean something, names that command nothing."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcc_sim.report.text import BARS, sparkline
from tests import terminal
from tests.program import rccsim


def on_terminal(*words, **env):
    """Run a command with both streams on one terminal; return what it shows."""
    return terminal.on_terminal(*words, width=60, errors=True, PYTHONUTF8="1", **env)[1]


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=500), st.integers(1, 120))
def test_a_sparkline_fits_and_shows_least_and_largest(values, width):
    line = sparkline(values, width)
    assert len(line) == min(width, len(values))
    assert set(line) <= set(BARS)
    if max(values) > min(values):
        assert BARS[-1] in line
        if len(values) <= width:
            assert line[values.index(min(values))] == BARS[0]


@given(st.integers(0, 4999))
def test_a_sparkline_never_hides_a_spike(row):
    values = [0.0] * 5000
    values[row] = 1.0
    assert sparkline(values, 50)[row * 50 // 5000] == BARS[-1]


def test_rows_without_a_value_are_a_blank_and_nothing_is_nothing():
    assert sparkline([1.0, float("nan"), 2.0], 3) == "▁ █"
    assert sparkline([], 10) == sparkline([float("nan")], 10) == ""


@pytest.fixture
def nasty(tmp_path):
    """Return a folder with a trace whose name would redden and clear a terminal."""
    name = "a\x1b[31m\x1b[2Jb<script>.csv"
    rows = "\n".join(f"{t},{t % 3},{10 + t % 7}" for t in range(50))
    (tmp_path / name).write_text(f"time_s,speed_mps,battery_power_w\n{rows}\n")
    return tmp_path, name


@pytest.mark.parametrize("command", ["energy", "check", "convert"])
def test_no_escape_sequence_of_a_name_reaches_the_terminal(nasty, command):
    folder, name = nasty
    shown = on_terminal(command, name, cwd=folder, NO_COLOR="1")
    assert "Traceback" not in shown and "script" in shown
    assert "\x1b[31m" not in shown and "\x1b[2J" not in shown


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ("gap",),
        ("check",),
        ("diagnose", "--candidates", "auxiliary_load", "--html", "page.html"),
    ],
    ids=lambda words: words[0],
)
def test_a_log_and_a_vehicle_with_bad_names_stay_text_within_60_columns(
    words, tmp_path
):
    (tmp_path / "car.toml").write_text(
        '[vehicle]\nname = "car"\nextends = "rcc"\n'
        'title = "x\\u001b[31m<script>alert(1)</script>"\n'
    )
    log = "a\x1b[31m\x1b[2Jb<script>.csv"
    drive = ("simulate", "rcc", "--cycle", "udds[20:60]", "-o", log)
    on_terminal(*drive, "--with", "auxiliary_load:power_w=3", cwd=tmp_path)
    shown = on_terminal(
        words[0], log, "--vehicle", "car.toml", *words[1:], cwd=tmp_path, NO_COLOR="1"
    )
    assert "Traceback" not in shown and "error: " not in shown
    assert "\x1b[31m" not in shown and "\x1b[2J" not in shown
    told = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown).split("\n")
    assert len(told) > 3
    assert max(len(line.strip("\r").rpartition("\r")[2]) for line in told) <= 60
    for page in tmp_path.glob("*.html"):
        text = page.read_text("utf-8")
        assert "\x1b" not in text and text.count("<script") == 2


def test_without_colour_nothing_is_coloured_and_bars_fit_the_width(nasty):
    folder, name = nasty
    shown = on_terminal("energy", name, cwd=folder, NO_COLOR="1")
    assert not re.search(r"\x1b\[(3|4|9)\d", shown)
    plain = re.sub(r"\x1b\[[0-9;]*m", "", shown)
    assert any(set(BARS) & set(line) for line in plain.splitlines())
    assert max(len(line.rstrip("\r")) for line in plain.splitlines()) <= 60


def test_a_pipe_has_data_alone(nasty):
    folder, name = nasty
    done = rccsim("energy", name, cwd=folder)
    assert done.returncode == 0 and done.stderr == ""
    assert not set(BARS) & set(done.stdout) and "\x1b" not in done.stdout
