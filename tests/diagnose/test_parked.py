"""A car that is parked: what its sensors scatter by moves nothing."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.residuals.posed import kept_still, problem_of
from rcc_sim.diagnose.run import diagnose
from tests.scaled_drive import written

CAR = load_vehicle("rcc")


def parked(folder, *, extra=0.0, seconds=40.0, rate=50.0):
    """Return a log of a car that stands, its battery giving some current more. [A]"""
    rng = np.random.default_rng(12)
    n = round(seconds * rate)
    columns = {
        "time_s": np.arange(n) / rate,
        "speed_ref_mps": np.zeros(n),
        "speed_mps": rng.normal(0, 0.01, n),
        "motor_current_a": rng.normal(0, 0.1, n),
        "battery_voltage_v": 12 + rng.normal(0, 0.02, n),
        "battery_current_a": extra + rng.normal(0, 0.05, n),
    }
    return written(columns, CAR, folder)


@pytest.mark.parametrize("extra", [0.0, 0.25])
def test_its_noise_is_no_friction(tmp_path, extra):
    """A friction, an iron loss, a slope or a rolling resistance was named at 99 %."""
    found = diagnose([parked(tmp_path, extra=extra)], CAR)
    named = [a.cause.effect for a in found.asserted]
    assert named == ["auxiliary_load"] * bool(extra)
    if extra:
        power = found.asserted[0].figures["power_w"]
        assert power.low < 12 * extra < power.high


def test_where_it_is_asked_to_move_its_speed_stays_as_it_was_measured(tmp_path):
    drive = problem_of(parked(tmp_path).log, CAR).drive
    n = len(drive.time)
    assert np.count_nonzero(drive.measured.speed) < 0.01 * n  # the mean's ends
    speed = 0.01 * np.sin(np.arange(n))
    speed[n // 2 :] += 0.5
    moves = drive.known_as(speed=speed)
    found = kept_still(moves).measured.speed
    still = found == 0
    assert still[30 : n // 2 - 30].all() and not still[n // 2 :].any()
    asked = moves.commanded(ref=np.full(n, 0.2))
    np.testing.assert_array_equal(kept_still(asked).measured.speed, speed)
