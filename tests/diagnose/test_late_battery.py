"""Readings that come late are a sensor's delay; no hill, load or mass."""

from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged, open_log
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting.descent import of_tolerances
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import offsets_of
from rcc_sim.diagnose.judge.misread import behind
from rcc_sim.diagnose.residuals.lateness import as_late
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

CAR = load_vehicle("tesla_model_3")
ROW = 0.1


def late_log(folder, rows: int, seed: int, corner_s: float = 1.0):
    """A town drive at 10 Hz, voltage and current some rows late; or speed, if less."""
    cycle = parse_cycle("udds[0:400]")
    fine = np.arange(0.0, 400.0, 0.01)
    ends = np.interp(fine, cycle.time_s, cycle.speed_mps)
    width = 2 * round(50 * corner_s) + 1
    even = np.ones(width) / width
    speed = np.convolve(np.pad(ends, width // 2, mode="edge"), even, "valid")
    motion = Trace({"time_s": fine, "speed_mps": speed}, name="fine")
    exact = replay(CAR, drive_of(motion, CAR))
    rng = np.random.default_rng(seed)
    log = {"time_s": fine[::10]}
    for c, noise in (("speed_mps", 0.02), ("battery_voltage_v", 0.3),
                     ("battery_current_a", 0.5)):  # fmt: skip
        x = speed if c == "speed_mps" else exact[c]
        log[c] = x[::10] + rng.normal(0, noise, len(log["time_s"]))
    log["speed_mps"] = np.maximum(log["speed_mps"], 0.0)
    for c in ("battery_voltage_v", "battery_current_a") if rows > 0 else ("speed_mps",):
        first = np.full(abs(rows), log[c][0])
        log[c] = np.concatenate([first, log[c]])[: len(fine[::10])]
    path, table = folder / "log.csv", np.column_stack(list(log.values()))
    head = ",".join(log)
    np.savetxt(path, table, fmt="%.7g", delimiter=",", header=head, comments="")
    return open_log(path, CAR)


@pytest.mark.parametrize(
    "rows", [8, *(pytest.param(n, marks=pytest.mark.thorough) for n in (-4, 3, -10))]
)
def test_the_delay_is_found_and_nothing_else(tmp_path, rows):
    found = diagnose([late_log(tmp_path, rows, seed=abs(rows))], CAR).document()
    (cause,) = found["causes"]
    assert cause["effect"] == "sensor_delay"
    ((name, figure),) = cause["parameters"].items()
    assert name == ("battery_delay_s" if rows > 0 else "speed_delay_s")
    # a sample stands for no mean: half a row is no error
    assert figure["value"] == pytest.approx(abs(rows) * ROW, abs=0.5 * ROW)
    assert figure["low"] < abs(rows) * ROW < figure["high"]


@pytest.mark.parametrize(
    "corner_s", [1.0, pytest.param(0.0, marks=pytest.mark.thorough)]
)
def test_no_delay_is_found_where_there_is_none(tmp_path, corner_s):
    """Nor in the corners of a cycle that is driven to the letter."""
    log = late_log(tmp_path, 0, seed=1, corner_s=corner_s)
    found = diagnose([log], CAR).document()
    assert found["causes"] == []


def test_means_since_the_row_before_are_no_delay():
    """They are half a row old, and a noisy speed is smoothed besides."""
    cycle = parse_cycle("udds[0:500]")
    key = "effects.auxiliary_load.power_w"
    stated = CAR.figures()[key].value
    true = CAR.changed(settings={key: stated + 1200.0})
    run = simulate(true, cycle, imposed=True, output_rate=10).trace
    rng = np.random.default_rng(3)
    log = {"time_s": run["time_s"]}
    for c, noise in (("speed_mps", 0.05), ("battery_voltage_v", 0.3),
                     ("battery_current_a", 0.5)):  # fmt: skip
        log[c] = run[c] + rng.normal(0, noise, len(run))
    log["speed_mps"] = np.maximum(log["speed_mps"], 0.0)
    found = diagnose([Logged(Trace(log, name="drive"), (), None)], CAR).document()
    (cause,) = found["causes"]
    assert cause["effect"] == "auxiliary_load"
    figure = cause["parameters"]["power_w"]
    assert figure["stated"] == stated
    assert figure["low"] < stated + 1200.0 < figure["high"]


def torque_log(late_s: float, rate: float):
    """A town drive with its torque, and a battery whose meter is late."""
    cycle = parse_cycle("udds[0:400]")
    t = np.arange(0.0, 400.0, 0.01)
    even = np.ones(101) / 101
    ends = np.pad(np.interp(t, cycle.time_s, cycle.speed_mps), 50, mode="edge")
    speed = np.convolve(ends, even, "valid")
    motion = Trace({"time_s": t, "speed_mps": speed}, name="fine")
    exact = replay(CAR, drive_of(motion, CAR))
    exact["speed_mps"] = speed
    rng = np.random.default_rng(4)
    rows = slice(None, None, round(100 / rate))
    log = {"time_s": t[rows]}
    for c, noise in (("speed_mps", 0.01), ("motor_torque_nm", 0.3),
                     ("battery_power_w", 100.0)):  # fmt: skip
        late = np.interp(t - late_s * (c == "battery_power_w"), t, exact[c])
        log[c] = late[rows] + noise * rng.normal(size=len(t[rows]))
    log["speed_mps"] = np.maximum(log["speed_mps"], 0.0)
    return Trace(log, name="drive")


@pytest.mark.parametrize(
    "late_s, rate",
    [
        (0.35, 10.0),
        pytest.param(0.35, 50.0, marks=pytest.mark.thorough),
        (0.0, 10.0),
    ],
)
def test_power_later_than_a_measured_torque_is_a_delay_and_no_load(late_s, rate):
    """The noise model would remember what is late; what it says is told by its rows."""
    log = torque_log(late_s, rate)
    found = diagnose([Logged(log, (), None)], CAR).document()
    if not late_s:
        assert found["causes"] == []
        return
    (cause,) = found["causes"]
    ((name, figure),) = cause["parameters"].items()
    assert name == "battery_delay_s"
    assert figure["value"] == pytest.approx(late_s, abs=0.02)
    assert figure["low"] < late_s < figure["high"]


def polled(late_s: float, seed: int = 1):
    """A log at 1 Hz as of a diagnostic socket: whole km/h, the battery asked later."""
    fine = np.arange(0.0, 900.0, 0.01)
    ends = parse_cycle("udds[0:900]")
    even = np.ones(101) / 101
    speed = np.interp(fine, ends.time_s, ends.speed_mps)
    speed = np.convolve(np.pad(speed, 50, mode="edge"), even, "valid")
    exact = replay(CAR, drive_of(Trace({"time_s": fine, "speed_mps": speed}), CAR))
    rng = np.random.default_rng(seed)
    at = np.arange(5.0, 890.0) + rng.uniform(-0.02, 0.02, 885)
    columns = {
        "time_s": at,
        "speed_mps": np.round(3.6 * np.interp(at, fine, speed)) / 3.6,
    }
    for c, step in (("battery_voltage_v", 0.5), ("battery_current_a", 0.1)):
        read = np.interp(at - late_s, fine, exact[c])
        columns[c] = step * np.round((read + rng.normal(0, step, len(at))) / step)
    return Logged(Trace(columns, name="polled"), (), None)


@pytest.mark.slow
@pytest.mark.parametrize("late_s", [-0.3, 0.3, 1.0])
def test_a_log_that_was_polled_may_have_its_battery_a_little_late(late_s):
    """Or early: a speed two rows late, and a battery nearly as late, is no cause."""
    found = diagnose([polled(late_s)], CAR)
    assert found.asserted == ()
    # a mean since the row before is as late as a sample of half a row ago
    (problem,) = found.found.engine.problems
    behind = 0.5 * min(problem.drive.window, problem.row)
    value = as_late(offsets_of(found.fit.values, 0), problem.row)
    assert value == pytest.approx(late_s - behind, abs=0.25 * problem.row)
    told = [f for f in found.gap.findings if f.kind == "late"]
    assert len(told) == (late_s > 0.5)  # half a row is nothing to speak of


@pytest.mark.slow
@pytest.mark.parametrize("late_s", [0.3, 0.65, 1.0, 1.3])
def test_how_late_one_comes_is_told_to_a_quarter_of_a_row(late_s):
    """A mean since the row before is as late as a sample of half a row ago."""
    engine = Engine([problem_of(polled(late_s).log, CAR)])
    (problem,) = engine.problems
    behind = 0.5 * min(problem.drive.window, problem.row)
    off = offsets_of(of_tolerances(engine).values, 0)
    found = as_late(off, problem.row) + behind
    assert found == pytest.approx(late_s, abs=0.25 * problem.row)


def test_a_delay_that_is_stated_or_named_is_not_doubted_besides():
    log, stated = polled(1.0).log, {"value": 0.7, "sd": 0.2}
    knows = CAR.changed(settings={"sensors.battery_current_a.latency_s": stated})
    named = SimpleNamespace(effect="sensor_delay")
    here, off = problem_of(log, CAR), {"flows_-1": 0.7, "flows_-2": 0.1}
    (told,) = behind(here, [], off)
    assert told.kind == "late" and "0.9 s later" in told.what
    assert not behind(here, [named], off)
    assert not behind(problem_of(log, knows), [], off)
