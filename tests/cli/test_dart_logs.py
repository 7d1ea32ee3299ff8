"""What `coastdown` and `check` say of the DART's own logs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.program import rccsim

DART = Path(__file__).resolve().parents[3] / "shared/data/real_rc/dart_jetracer"
STEPS = sorted(DART.glob("1*_step_input_data*/*.csv"))

pytestmark = pytest.mark.skipif(not STEPS, reason="the DART logs are not here")


def answer(*words):
    done = rccsim(*words, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_step_inputs_coast_down_at_1_to_1_7_mps2_and_faster_from_more_speed():
    found = answer("coastdown", *STEPS, "--vehicle", "dart_jetracer")
    speed, slows = np.array(
        [(d["speed_mps"], d["deceleration_mps2"]) for d in found["decelerations"]]
    ).T
    assert (np.diff(slows) > 0).all()
    usual = np.interp([0.5, 1.0, 1.5, 2.0, 3.0], speed, slows)
    assert (usual > 1.0).all() and (usual < 1.7).all()
    assert {row["log"] for row in found["stretches"]} <= set(map(str, STEPS))


def test_the_step_inputs_agree_with_slopes_taken_by_hand():
    """Central differences of the encoder while the throttle is 0, by speed."""
    found = answer("coastdown", *STEPS, "--vehicle", "dart_jetracer")
    speeds, slopes = [], []
    for path in STEPS:
        names = path.read_text().splitlines()[0].split(",")
        table = np.genfromtxt(path, delimiter=",", skip_header=1)
        time, v, throttle, safety = (
            table[:, names.index(n)]
            for n in (
                *("elapsed time sensors", "vel encoder", "throttle"),
                "safety_value",
            )
        )
        coasts = throttle * (safety > 0) == 0
        for k in range(3, len(v) - 1):
            if coasts[k - 3 : k + 2].all() and v[k - 1 : k + 2].min() > 0.3:
                speeds.append(v[k])
                slopes.append((v[k - 1] - v[k + 1]) / (time[k + 1] - time[k - 1]))
    for low in (0.75, 1.25, 1.75, 2.25):
        here = (np.array(speeds) >= low) & (np.array(speeds) < low + 0.5)
        middle = float(np.mean(np.array(speeds)[here]))
        fit = np.interp(
            middle,
            [d["speed_mps"] for d in found["decelerations"]],
            [d["deceleration_mps2"] for d in found["decelerations"]],
        )
        assert fit == pytest.approx(np.array(slopes)[here].mean(), abs=0.1)


@pytest.mark.parametrize("path", STEPS[:5], ids=lambda p: p.stem[-8:])
def test_a_check_names_the_dead_channels_and_the_bias_of_the_imu(path):
    found = answer("check", path)["findings"]
    dead = {row["channel"] for row in found if row["kind"] == "dead"}
    assert dead == {"voltage", "current"}
    bias = [
        float(row["what"].split()[1])
        for row in found
        if row["kind"] == "bias" and row["channel"] == "accel_x_mps2"
    ]
    assert len(bias) == 1
    assert -0.55 < bias[0] < -0.2


SEEN = sorted(DART.glob("70_racetrack_lap_v_1/*.csv.gz"))


@pytest.mark.slow
@pytest.mark.skipif(not SEEN, reason="the log with motion capture is not here")
def test_the_gyro_is_as_late_as_its_shift_against_the_heading_says():
    """The shift at which gyro and motion capture agree best, without any vehicle."""
    words = ("--vehicle", "dart_jetracer", "--withhold", "sensor_delay")
    words += ("--candidates", "sensor_delay,steering_delay,steering_lag")
    found = answer("diagnose", SEEN[0], *words)
    (late,) = (c for c in found["causes"] if c["effect"] == "sensor_delay")
    table = pd.read_csv(SEEN[0])
    names = ("vicon time", "W (IMU)", "vicon yaw")
    time, gyro, yaw = (table[c].to_numpy() for c in names)
    fresh = np.flatnonzero(np.diff(gyro) != 0) + 1
    fine = np.arange(time[0], time[-1], 0.005)
    heading = np.interp(fine, time, np.unwrap(yaw))

    def differs(shift):
        at = time[fresh] - shift
        ends = (np.interp(at + side, fine, heading) for side in (0.025, -0.025))
        turn = next(ends) - next(ends)
        return float(np.median(np.abs(gyro[fresh] - turn / 0.05)))

    best = min(np.arange(0.0, 0.15, 0.005), key=differs)
    told = {name: figure["value"] for name, figure in late["parameters"].items()}
    of_gyro = told.get("delay_s", 0.0) + told.get("yaw_rate_delay_s", 0.0)
    assert of_gyro == pytest.approx(best, abs=0.015)
