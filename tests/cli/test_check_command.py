"""`rccsim check` as a user meets it: pipes, several logs, verdicts, mistakes."""

import gzip
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.program import rccsim

CASES = Path(__file__).resolve().parents[3] / "shared" / "cases"
DART = Path(__file__).resolve().parents[3] / "shared/data/real_rc/dart_jetracer"


@pytest.fixture
def log(tmp_path):
    """A car that speeds up and slows down, with an accelerometer."""
    rng = np.random.default_rng(0)
    t = np.arange(0, 60, 0.02)
    table = pd.DataFrame(
        {
            "time_s": t,
            "speed_mps": 3 - 3 * np.cos(t / 2) + rng.normal(0, 0.005, len(t)),
            "accel_x_mps2": 1.5 * np.sin(t / 2) + rng.normal(0, 0.1, len(t)),
        }
    )
    path = tmp_path / "log.csv"
    table.to_csv(path, index=False)
    return path


def spoilt(log, column, change):
    table = pd.read_csv(log)
    table[column] = change(table[column])
    path = log.with_name(f"spoilt_{column}.csv")
    table.to_csv(path, index=False)
    return path


def test_a_sound_log_passes_and_says_so(log):
    done = rccsim("check", log, "--strict", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["sound"] is True
    assert said["rate_hz"] == pytest.approx(50)
    assert said["duration_s"] == pytest.approx(59.98)
    assert ": sound (" in done.stderr


def test_strict_fails_a_log_in_g_and_names_it_and_the_mend(log):
    bad = spoilt(log, "accel_x_mps2", lambda a: a / 9.80665)
    assert rccsim("check", bad).returncode == 0
    done = rccsim("check", log, bad, "--strict", "--json")
    assert done.returncode == 1
    assert str(bad) in done.stderr.splitlines()[-1]
    sound, unsound = json.loads(done.stdout)["logs"]
    assert sound["sound"] and not unsound["sound"]
    assert unsound["unusable"] == ["accel_x_mps2"]
    assert unsound["findings"][0]["factor"] == pytest.approx(9.80665)


def test_csv_has_a_row_a_finding_with_what_where_sure_and_action(log):
    bad = spoilt(log, "accel_x_mps2", lambda a: -a)
    done = rccsim("check", bad, "--csv")
    head, first, *_ = done.stdout.splitlines()
    assert {"log", "kind", "channel", "what", "where", "sure", "action"} <= set(
        head.split(",")
    )
    assert "sign,accel_x_mps2" in first


def test_a_simulated_drive_from_a_pipe_is_sound():
    drive = rccsim("simulate", "rcc", "--cycle", "udds[20:60]")
    done = rccsim("check", "-", "--vehicle", "rcc", "--strict", stdin=drive.stdout)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "empty"),
        ("hello\nworld\n", "not a log"),
        ("time_s,speed_mps\n", "rows"),
        ("time_s,speed_mps\n0,1\n", "one row"),
        ("time_s,speed_mps\n0,1\n1,2\n2,two\n", "row 3"),
        ("time_s\n0\n1\n2\n3\n", "no channel"),
    ],
)
def test_what_is_no_log_is_one_line_of_error(tmp_path, text, words):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    done = rccsim("check", path)
    assert done.returncode == 2
    assert not done.stdout
    assert sum(line.startswith("error: ") for line in done.stderr.splitlines()) == 1
    assert words in done.stderr
    assert "bad.csv" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_broken_gzip_is_one_line_of_error(tmp_path, log):
    path = tmp_path / "cut.csv.gz"
    path.write_bytes(gzip.compress(log.read_bytes())[:-200])
    done = rccsim("check", path)
    assert done.returncode == 2
    assert "gzip" in done.stderr


@pytest.mark.skipif(not CASES.is_dir(), reason="../shared/cases is not here")
def test_sound_logs_by_another_simulator_earn_nothing_above_a_note():
    logs = sorted(CASES.glob("p*/log.csv.gz"))
    done = rccsim("check", *logs, "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)["logs"]
    assert len(said) == len(logs)
    assert [one["log"] for one in said if not one["sound"]] == []


@pytest.mark.skipif(not DART.is_dir(), reason="../shared/data is not here")
def test_the_jetracer_has_dead_battery_sensors_and_a_biased_accelerometer(tmp_path):
    names = {
        "elapsed time sensors": "time_s",
        "current": "battery_current_a",
        "voltage": "battery_voltage_v",
        "acc x (IMU)": "accel_x_mps2",
        "vel encoder": "speed_mps",
        "throttle": "throttle",
    }
    source = sorted((DART / "10_step_input_data_rubbery_floor").glob("*.csv"))[0]
    table = pd.read_csv(source)[list(names)].rename(columns=names)
    path = tmp_path / "dart.csv"
    table.to_csv(path, index=False)
    said = json.loads(rccsim("check", path, "--json").stdout)
    assert set(said["unusable"]) == {"battery_current_a", "battery_voltage_v"}
    (bias,) = [f for f in said["findings"] if f["kind"] == "bias"]
    assert bias["channel"] == "accel_x_mps2"
    assert -0.52 <= float(bias["what"].split()[1]) <= -0.3  # SOURCES.md


def test_a_column_map_is_taken_as_gap_takes_it(log, tmp_path):
    table = pd.read_csv(log).rename(columns={"speed_mps": "pace"})
    table["pace"] *= 3.6
    odd = tmp_path / "odd.csv"
    table.to_csv(odd, index=False)
    columns = tmp_path / "map.toml"
    columns.write_text(
        '[columns]\ntime_s = "time_s"\naccel_x_mps2 = "accel_x_mps2"\n'
        'speed_mps = { from = "pace", unit = "km/h" }\n'
    )
    done = rccsim("check", odd, "--map", columns, "--reader", "csv", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["sound"] is True
    assert "speed_mps" in said["channels"]


def test_channels_of_several_rates_are_not_lost_rows(log, tmp_path):
    table = pd.read_csv(log)
    rng = np.random.default_rng(1)
    fast = pd.DataFrame({"time_s": table["time_s"] + 0.007})
    fast["battery_voltage_v"] = rng.normal(8.0, 0.02, len(fast))
    both = tmp_path / "both.csv"
    pd.concat([table[::7], fast]).sort_values("time_s").to_csv(both, index=False)
    said = json.loads(rccsim("check", both, "--json").stdout)
    kinds = {finding["kind"] for finding in said["findings"]}
    assert "clocks" in kinds
    assert not kinds & {"lost_rows", "gap"}
    assert said["rate_hz"] == pytest.approx(50 / 7, rel=0.01)


def test_a_log_that_cannot_be_read_does_not_hide_what_the_others_hold(log, tmp_path):
    empty, other = tmp_path / "empty.csv", tmp_path / "other.csv"
    empty.write_text("")
    other.write_text("no log")
    done = rccsim("check", empty, log, other, log, "--json")
    assert done.returncode == 2
    assert done.stderr.count(f"{log}: 3000 rows in use") == 2
    for path in (empty, other):
        assert f"error: {path}: " in done.stderr
    assert len(json.loads(done.stdout)["logs"]) == 2
    none = rccsim("check", empty, other, "--json")
    assert (none.returncode, none.stdout) == (2, "")


def test_a_column_without_a_unit_is_told(log):
    table = pd.read_csv(log)
    table.assign(I_bat=1.5, throttle=0.1).to_csv(log, index=False)
    found = json.loads(rccsim("check", log, "--json").stdout)["findings"]
    told = {f["channel"]: f["what"] for f in found if f["kind"] == "unknown"}
    assert list(told) == ["I_bat"] and "no unit" in told["I_bat"]


def test_what_a_terminal_shows_goes_into_a_pipe_or_a_file_where_asked(log, tmp_path):
    steep = spoilt(log, "accel_x_mps2", lambda x: x / 9.80665)
    piped = rccsim("check", log, steep, "--text")
    assert piped.returncode == 0, piped.stderr
    first, second, *table = piped.stdout.splitlines()
    assert ": sound (" in first
    assert ": not sound (" in second
    assert any("accel_x_mps2" in line for line in table)
    assert not piped.stderr
    written = rccsim("check", log, steep, "--text", "-o", tmp_path / "said.txt")
    assert (tmp_path / "said.txt").read_text() == piped.stdout
    assert not written.stdout
    both = rccsim("check", log, "--text", "--json")
    assert both.returncode == 2
    assert "--text and --json: one of them" in both.stderr
    fleet = rccsim("check", log, "--each", "--text")
    assert "--text: belongs to a single log" in fleet.stderr
