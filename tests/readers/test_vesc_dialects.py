"""VESC Tool's CSV as other firmware, locales and spreadsheets leave it."""

from __future__ import annotations

import numpy as np
import pytest

from rcc_sim.readers import read_log
from tests.readers import making

NEW = (
    "_setup",
    "imu",
    "acc",
    "gyro",
    "gnss",
    "roll",
    "pitch",
    "yaw",
    "speed",
    "tacho_",
)
"""Marks of the columns that an older firmware does not have."""


def table(path):
    """Names and rows of fields of a VESC Tool log."""
    lines = path.read_text().splitlines()
    return lines[0].split(";"), [line.split(";") for line in lines[1:]]


def same(log, true, names):
    for name in names:
        ours, theirs = log.trace[name], true.trace[name]
        assert np.array_equal(ours, theirs, equal_nan=True), name


@pytest.fixture
def ride(tmp_path):
    return making.write_vesc(tmp_path / "ride.csv")


def test_a_log_of_older_firmware_gives_what_it_has(tmp_path, ride):
    names, rows = table(ride)
    kept = [k for k, n in enumerate(names) if not any(mark in n for mark in NEW)]
    assert len(kept) <= len(names) - 10
    lines = [";".join(row[k] for k in kept) for row in [names, *rows]]
    old = tmp_path / "old.csv"
    old.write_text("\n".join(lines) + "\n")
    log, true = read_log(old), read_log(ride)
    assert log.reader == "vesc_tool"
    assert "speed_mps" not in log.trace
    assert "yaw_rate_radps" not in log.trace
    same(log, true, ["time_s", "motor_speed_erpm", "motor_current_a"])
    same(log, true, ["battery_voltage_v", "battery_current_a", "duty_cycle"])


@pytest.mark.parametrize("ends", [";", ""])
def test_decimal_commas_give_the_same_numbers(tmp_path, ride, ends):
    names, rows = table(ride)
    cut = -1 if ends == "" else None
    lines = [";".join(row[:cut]).replace(".", ",") for row in [names, *rows]]
    path = tmp_path / "comma.csv"
    path.write_text("\n".join(lines) + "\n")
    log, true = read_log(path), read_log(ride)
    assert log.reader == "vesc_tool"
    same(log, true, true.trace.columns)
    assert any("decimal ','" in note for note in log.notes)


@pytest.mark.parametrize("separator", [",", "\t"])
def test_another_separator_gives_the_same_numbers(tmp_path, ride, separator):
    path = tmp_path / "other.csv"
    path.write_text(ride.read_text().replace(";", separator))
    log, true = read_log(path), read_log(ride)
    assert log.reader == "vesc_tool"
    same(log, true, true.trace.columns)


def test_a_ride_across_midnight_goes_on(tmp_path, ride):
    names, rows = table(ride)
    place = names.index("ms_today")
    first = float(rows[0][place])
    day = 86_400_000
    for row in rows:
        late = float(row[place]) - first + day - 2000
        row[place] = str(int(late % day))
    path = tmp_path / "night.csv"
    path.write_text("\n".join(";".join(row) for row in [names, *rows]) + "\n")
    time = read_log(path).trace["time_s"]
    true = read_log(ride).trace["time_s"]
    assert (np.diff(time) > 0).all()
    assert np.diff(time) == pytest.approx(np.diff(true), abs=2e-3)
