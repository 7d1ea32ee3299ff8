"""A draft of a column map: what the rows give away beside the header."""

from __future__ import annotations

import numpy as np
import pytest
from drives import CAR, ROVER, SEDAN, TRUCK, logged

from rcc_sim.analyse.logcheck.draft import checked_draft
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.readers import read_log
from rcc_sim.source import open_source
from rcc_sim.units import G

HEADER = {
    "time_s": ("Time", 1.0),
    "speed_mps": ("Vehicle Speed", 3.6),
    "speed_ref_mps": ("Target Speed", 3.6),
    "steer_cmd_rad": ("Steering", 180 / np.pi),
    "yaw_rate_radps": ("Yaw rate", 180 / np.pi),
    "accel_x_mps2": ("ax", 1 / G),
    "accel_y_mps2": ("ay", 1 / G),
    "battery_voltage_v": ("Battery Voltage", 1.0),
    "battery_current_a": ("Battery Current", -1.0),
}
"""Our column -> what a logger calls it, without a unit, and its factor to theirs."""


def written(path, columns):
    """Write columns as a CSV file."""
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, "%.9g", ",", header=",".join(columns), comments="")
    return open_source(path)


SPEEDS = ("speed_mps", "speed_ref_mps")
RIGHT, MPH = dict.fromkeys(HEADER, 1.0), dict.fromkeys(SPEEDS, 1 / 0.44704)
WAYS = {
    "ours": RIGHT,
    "theirs": {},
    "mph and g": MPH | dict.fromkeys(("steer_cmd_rad", "yaw_rate_radps"), 1.0),
    "mph, degrees and g": MPH | {"battery_current_a": 1.0},
    "angles of the wheels in radians": {"steer_cmd_rad": 1.0},
    "km/h alone": RIGHT | dict.fromkeys(SPEEDS, 3.6),
}
"""What is wrong -> factors in place of those of the header."""


@pytest.mark.parametrize("drive", [CAR, ROVER, TRUCK, SEDAN], ids=lambda d: d[0])
@pytest.mark.parametrize("way", WAYS)
def test_units_and_signs_that_the_rows_give_away_are_drafted(tmp_path, drive, way):
    """Speeds in km/h, turning in degrees, forces in g, a current the other way."""
    log = logged(*drive)
    theirs = {
        name: log[ours] * WAYS[way].get(ours, factor)
        for ours, (name, factor) in HEADER.items()
    }
    path, by = tmp_path / "ride.csv", tmp_path / "map.toml"
    draft, unread = checked_draft(written(path, theirs), load_vehicle(drive[0]))
    assert unread is None
    assert {e.column: e.name for e in draft.entries} == {
        ours: name for ours, (name, _) in HEADER.items()
    }
    by.write_text(draft.toml())
    trace = read_log(path, columns=by).trace
    for column in HEADER:
        expected = log[column] - (log["time_s"][0] if column == "time_s" else 0.0)
        got = trace[column] - (trace["time_s"][0] if column == "time_s" else 0.0)
        np.testing.assert_allclose(got, expected, rtol=1e-4, atol=1e-6, err_msg=column)


def test_a_draft_of_a_log_in_our_own_columns_keeps_every_one(tmp_path):
    log = {"time_s": np.arange(5.0), "voltage_d_v": np.ones(5), "x_m": np.arange(5.0)}
    log |= {"battery_voltage_v": np.full(5, 12.0), "energy_kinetic_j": np.arange(5.0)}
    draft, _ = checked_draft(written(tmp_path / "own.csv", log))
    assert {e.column: e.name for e in draft.entries} == {name: name for name in log}


def test_a_draft_says_why_its_rows_are_not_judged(tmp_path):
    log = {"Time": np.arange(5.0), "Vehicle Speed": np.full(5, np.nan)}
    draft, unread = checked_draft(written(tmp_path / "blank.csv", log))
    assert unread is not None and "blank" in unread
    assert "speed_mps" in draft.toml()
