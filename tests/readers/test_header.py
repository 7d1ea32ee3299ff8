"""A header is found under titles, with a line of units, and among real logs' words."""

from __future__ import annotations

import numpy as np
import pytest

from rcc_sim.errors import InputError
from rcc_sim.readers import read_log
from rcc_sim.readers.csv_table import text_table
from rcc_sim.readers.words import date_seconds
from rcc_sim.source import open_source

ROWS = "0,1.5,2\n1,2.5,3\n2,3.5,4\n"
TITLE = "A drive,,\nDate,2025-03-04,\n,,\n"


def table(folder, text):
    (folder / "log.csv").write_text(text)
    return text_table(open_source(folder / "log.csv"))


@pytest.mark.parametrize(
    ("text", "names", "above"),
    [
        ("time_s,v,i\n" + ROWS, ("time_s", "v", "i"), 0),
        (TITLE + "time_s,v,i\n" + ROWS, ("time_s", "v", "i"), 3),
        ("A drive\n\ntime_s,v,i\n" + ROWS, ("time_s", "v", "i"), 2),
        ("t,v,i\ns,km/h,A\n" + ROWS, ("t [s]", "v [km/h]", "i [A]"), 0),
        ("A drive,,\nt,v,i\ns,-,m/s2\n" + ROWS, ("t [s]", "v", "i [m/s2]"), 1),
        ("t,mode,i\n0,eco,1\n1,eco,2\n", ("t", "mode", "i"), 0),
        ("t,mode,note\n0,eco,a\n1,eco,b\n", ("t", "mode", "note"), 0),
        (ROWS, ("0", "1.5", "2"), 0),
        ("t;v;i\n0;1,5;2\n", ("t", "v", "i"), 0),
    ],
)
def test_a_header_is_found_where_it_is(tmp_path, text, names, above):
    found = table(tmp_path, text)
    assert (found.names, found.above) == (names, above)
    first = text.splitlines()[found.skip]
    assert first.replace(";", ",").split(",")[0] in ("0", "1")


def test_a_spreadsheet_is_read_as_it_was_saved(tmp_path):
    (tmp_path / "log.csv").write_text(
        "Log of a drive;;\nDriver;Ann;\n;;\nTime;Speed;Battery current\ns;km/h;A\n"
        "0,0;36,0;1,5\n0,5;#N/A;2,5\n1,0;72,0;#DIV/0!\n"
    )
    (tmp_path / "map.toml").write_text(
        '[map]\n[columns]\ntime_s = { from = "Time [s]" }\n'
        'speed_mps = { from = "Speed [km/h]", unit = "km/h" }\n'
        'battery_current_a = { from = "Battery current [A]" }\n'
    )
    log = read_log(tmp_path / "log.csv", columns=tmp_path / "map.toml")
    np.testing.assert_allclose(log.trace["time_s"], [0.0, 0.5, 1.0])
    np.testing.assert_allclose(log.trace["speed_mps"], [10.0, np.nan, 20.0])
    np.testing.assert_allclose(log.trace["battery_current_a"], [1.5, 2.5, np.nan])
    assert any("3 lines above the header" in note for note in log.notes)


@pytest.mark.parametrize(
    "words",
    [
        ["2025-03-24 23:59:59.5", "2025-03-25 00:00:00.25"],
        ["24.03.2025 23:59:59,5", "25.03.2025 00:00:00,25"],
        ["24/03/2025 23:59:59.5", "25/03/2025 00:00:00.25"],
        ["3/24/2025 11:59:59.5 PM", "3/25/2025 12:00:00.25 AM"],
    ],
)
def test_a_date_is_what_a_spreadsheet_writes(words):
    assert date_seconds(words, "log") == pytest.approx([1742860799.5, 1742860800.25])


def test_a_date_that_could_be_another_is_asked_for():
    with pytest.raises(InputError, match="day or month first"):
        date_seconds(["3/4/2025 10:00:00", "3/4/2025 10:00:01"], "log")
    with pytest.raises(InputError, match="row 2: should be a date"):
        date_seconds(["24.03.2025 10:00:00", "noon"], "log")
