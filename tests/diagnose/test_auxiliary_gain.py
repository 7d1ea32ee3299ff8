"""A heater's meter that reads too little is told from loads, drags and other meters."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

CAR = load_vehicle("tesla_model_3")
NOISE = {"speed_mps": 0.01, "battery_voltage_v": 0.1, "battery_current_a": 0.3}


def heated(folder, read):
    """A town drive of five minutes whose heater's meter reads a share of its power."""
    rng = np.random.default_rng(5)
    cycle = parse_cycle("udds[0:300]")
    time = np.arange(0.0, 300.0, 0.1)
    speed = np.interp(time, cycle.time_s, cycle.speed_mps)
    speed = np.convolve(np.pad(speed, 5), np.ones(11) / 11, "valid")
    heater = 3000.0 * np.exp(-time / 100.0) + 800.0 * (time % 60.0 < 20.0)
    drive = {"time_s": time, "speed_mps": speed, "aux_power_w": heater}
    seen = replay(CAR, drive_of(Trace(drive, name="made"), CAR))
    log = {n: seen[n] + rng.normal(0, s, len(time)) for n, s in NOISE.items()}
    log = {"time_s": time, **log, "aux_power_w": read * heater}
    path = folder / "log.csv"
    table, head = np.column_stack([*log.values()]), ",".join(log)
    np.savetxt(path, table, fmt="%.6g", delimiter=",", header=head, comments="")
    return path


@pytest.mark.parametrize("read", [0.8, 1.0, 1.25])
def test_what_a_meter_reads_is_a_share_of_what_is_drawn(tmp_path, read):
    found = diagnose([open_log(heated(tmp_path, read), CAR)], CAR)
    named = {a.cause.effect: a.figures["gain"] for a in found.asserted}
    assert set(named) == (set() if read == 1.0 else {"auxiliary_gain"})
    for gain in named.values():
        assert gain.low < 1 / read < gain.high
        assert gain.value == pytest.approx(1 / read, rel=0.03)


@pytest.mark.parametrize(("hide", "read"), [((), 0.0), (["aux_power_w"], 1.0)])
def test_without_a_reading_there_is_no_gain_of_it(tmp_path, hide, read):
    log = open_log(heated(tmp_path, read), CAR, hide=hide)
    able = {c.effect for c in candidates_for([problem_of(log.log, CAR)])}
    assert "auxiliary_load" in able and "auxiliary_gain" not in able
