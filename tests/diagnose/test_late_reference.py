"""A reference that is heard late is told from a late motor and from late sensors."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

CAR, ROW, TICK = load_vehicle("rcc"), 0.01, 0.001
NOISE = {
    "speed_mps": 0.005,
    "yaw_rate_radps": 0.01,
    "accel_y_mps2": 0.08,
    "motor_current_a": 0.15,
}


def driven(delay, seed, turns):
    """A drive of 24 s whose loop is given, tick by tick, what was sent a while ago."""
    time = np.arange(0.0, 24.0, ROW)
    sent = 2.5 + 1.2 * np.sin(0.9 * time) + 0.5 * np.sin(2.3 * time)
    sent *= np.clip(time - 1.0, 0.0, 1.0)
    tick = np.arange(0.0, 24.0, TICK)
    steps = np.floor((tick - delay) / ROW + 1e-9) * ROW
    heard = Cycle("c", tick, np.interp(steps, time, sent))
    steer = (time, turns * 0.06 * np.sin(1.7 * time))
    car = CAR.changed(effects={"reference_sampling": {"period_s": TICK}})
    seen = simulate(car, heard, steer=steer, output_rate=1 / ROW).trace
    rng = np.random.default_rng(seed)
    columns = {c: seen[c].copy() for c in ("time_s", "steer_cmd_rad", *NOISE)}
    for name, sd in NOISE.items():
        columns[name] += rng.normal(0.0, sd, len(columns[name]))
    columns["speed_ref_mps"] = np.interp(columns["time_s"], time, sent)
    return [Logged(Trace(columns, name="drive"), (), None)]


@pytest.mark.parametrize(
    ("delay", "turns"),
    [
        (0.06, 1.0),
        pytest.param(0.063, 1.0, marks=pytest.mark.thorough),
        (0.0675, 0.0),
    ],
    ids=["whole rows", "parts of rows", "straight ahead"],
)
def test_a_late_reference_is_named(delay, turns):
    (cause,) = diagnose(driven(delay, 4, turns), CAR).asserted
    assert cause.cause.effect == "reference_delay"
    assert cause.probability > 0.95
    found = cause.figures["delay_s"]
    assert found.value == pytest.approx(delay, abs=0.002)
    assert found.low <= delay <= found.high


def test_straight_ahead_and_by_whole_rows_it_looks_like_late_sensors():
    found = diagnose(driven(0.06, 4, 0.0), CAR).document()
    likely = {r["effect"] for r in found["ranking"] if r["probability"] > 0.03}
    assert likely == {"reference_delay", "sensor_delay"}
