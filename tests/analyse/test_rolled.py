"""A speed that is of no use gives way to that which the motor's speed makes."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace, write_trace

CAR = load_vehicle("rcc")
KMH = 3.6
NOISE = {"speed_mps": 0.01, "motor_speed_radps": 2.5, "accel_x_mps2": 0.1}


@pytest.fixture(scope="module")
def drive():
    town = parse_cycle("udds[20:125]")
    cycle = Cycle("c", 0.2256 * town.time_s, 0.416 * town.speed_mps)
    run = simulate(CAR, cycle, output_rate=100.0).trace
    rng = np.random.default_rng(2)
    seen = {c: run[c] + rng.normal(0, sd, len(run)) for c, sd in NOISE.items()}
    asked = {c: run[c] for c in ("time_s", "speed_ref_mps", "steer_cmd_rad")}
    return asked | seen, run["speed_mps"]


def opened(columns, folder, **options):
    path = folder / "log.csv"
    with path.open("wb") as file:
        write_trace(Trace(columns), file)
    return open_log(path, CAR, **options)


def test_a_speed_in_another_unit_gives_way_to_the_motors(drive, tmp_path):
    columns, true = drive
    wrong = columns | {"speed_mps": KMH * columns["speed_mps"]}
    found = opened(wrong, tmp_path)
    assert {"unit", "rolled"} <= {f.kind for f in found.findings}
    lever = CAR.drivetrain.gear_ratio.value / CAR.tyres.radius_m.value
    sd = NOISE["motor_speed_radps"] / lever
    assert np.std(found.log["speed_mps"] - true) == pytest.approx(sd, rel=0.1)


def test_a_sound_speed_and_one_that_is_hidden_stay_as_they_are(drive, tmp_path):
    columns, _ = drive
    sound = opened(columns, tmp_path)
    np.testing.assert_allclose(sound.log["speed_mps"], columns["speed_mps"], atol=1e-6)
    hidden = opened(columns, tmp_path, hide=["speed_mps"])
    assert "speed_mps" not in hidden.log
    for one in (sound, hidden):
        assert "rolled" not in {f.kind for f in one.findings}


def test_without_the_motors_there_is_no_speed(drive, tmp_path):
    columns, _ = drive
    wrong = columns | {"speed_mps": KMH * columns["speed_mps"]}
    del wrong["motor_speed_radps"]
    assert "speed_mps" not in opened(wrong, tmp_path).log
