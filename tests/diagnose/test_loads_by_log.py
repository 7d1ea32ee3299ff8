"""Several logs, a heater on in one of them: each has its own load, and one is shown."""

import numpy as np
import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.deliver import write_mended
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import figures_of, own_key
from rcc_sim.diagnose.profiles.probe import Probe
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.report.screen import screen
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

CAR = load_vehicle("tesla_model_3")
LOAD = "effects.auxiliary_load.power_w"
BASE = CAR.figures()[LOAD].value
NOISE = {"speed_mps": 0.01, "battery_voltage_v": 0.1, "battery_current_a": 0.3}
LATE = 3000.0  # W, in the second half of one drive


def driven(path, cycle, heater, seed, noise=NOISE):
    """A log of a drive with a heater's power [W], a number a row."""
    rng = np.random.default_rng(seed)
    known = parse_cycle(cycle)
    time = np.arange(0.0, known.time_s[-1], 0.2)
    speed = np.interp(time, known.time_s, known.speed_mps)
    speed = np.convolve(np.pad(speed, 3, "edge"), np.ones(7) / 7, "valid")
    power = np.where(time > time[-1] / 2, heater, 0.0)
    columns = {"time_s": time, "speed_mps": speed, "aux_power_w": power}
    seen = replay(CAR, drive_of(Trace(columns, name="made"), CAR))
    log = {n: seen[n] + rng.normal(0, s, len(time)) for n, s in noise.items()}
    table = np.column_stack([time, *log.values()])
    head = ",".join(["time_s", *log])
    np.savetxt(path, table, fmt="%.6g", delimiter=",", header=head, comments="")
    return open_log(path, CAR)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs")
    drives = {"clean.csv": ("udds[0:340]", 0.0), "heated.csv": ("hwfet[0:340]", LATE)}
    logs = [
        driven(folder / name, cycle, heater, seed)
        for seed, (name, (cycle, heater)) in enumerate(drives.items())
    ]
    return diagnose(logs, CAR)


def test_each_log_has_its_own_load(found):
    (one,) = found.asserted
    assert one.cause.effect == "auxiliary_load"
    clean, heated = one.figures["power_w"].each
    for told, true in ((clean, BASE), (heated, BASE + LATE / 2)):
        assert told.low < true < told.high
        assert told.value == pytest.approx(true, rel=0.05)
    assert clean.most < BASE + 0.1 * LATE
    whole = one.figures["power_w"]
    assert whole.value == pytest.approx(BASE + LATE / 4, rel=0.05)


def test_the_log_that_is_farthest_off_is_the_one_shown(found):
    assert found.shown == 1
    document = found.document()
    assert document["log"].endswith("heated.csv")
    logs = document["causes"][0]["parameters"]["power_w"]["logs"]
    assert [round(x["value"] / BASE) for x in logs] == [1, round(1 + LATE / 2 / BASE)]
    hours = found.gap.measured["time_s"][-1] / 3600
    paid = found.prices.causes["auxiliary_load"]
    assert paid == pytest.approx(LATE / 2 * hours, rel=0.1)
    assert abs(found.prices.unexplained_wh) < 0.1 * paid
    told = " ".join(" ".join(screen(found, 400)).split())
    by_log = told.partition("mean power_w by log: ")[2].partition("RIVALS")[0]
    assert by_log.index("clean.csv") < by_log.index("heated.csv")
    assert "heated.csv: auxiliary_load" in told


def test_the_mended_file_holds_the_mean_over_all_logs(found, tmp_path):
    write_mended(found, tmp_path / "mended.toml")
    mended = load_vehicle(tmp_path / "mended.toml").figures()[LOAD]
    assert mended.value == pytest.approx(BASE + LATE / 4, rel=0.05)


def test_a_figure_of_one_log_stands_there_alone():
    values = {own_key(1, LOAD): 7.0, LOAD: 3.0, "bias.0.speed_mps": 1.0}
    assert figures_of(values) == figures_of(values, 0) == {LOAD: 3.0}
    assert figures_of(values, 1) == {LOAD: 7.0}


def test_on_another_log_the_file_that_is_written_is_judged(tmp_path):
    log = driven(tmp_path / "log.csv", "udds[0:340]", LATE, 9)
    held = driven(tmp_path / "held.csv", "hwfet[0:340]", LATE, 5)
    found = diagnose([log], CAR, holdouts=[held])
    write_mended(found, tmp_path / "mended.toml")
    mended = load_vehicle(tmp_path / "mended.toml")
    after = gap(open_log(tmp_path / "held.csv", mended), mended).energy.gap_percent
    assert found.proof.after == pytest.approx(after, abs=0.1)
    assert abs(after) < 0.3 * abs(found.proof.before)


def test_a_load_of_one_log_is_found_beside_a_log_that_tells_none(tmp_path):
    felt = {"speed_mps": 0.01, "accel_x_mps2": 0.1}
    blind = driven(tmp_path / "felt.csv", "udds[0:340]", 0.0, 3, felt)
    heated = driven(tmp_path / "heated.csv", "hwfet[0:340]", LATE, 1)
    alone, beside = (diagnose(logs, CAR) for logs in ([heated], [blind, heated]))
    for found in (alone, beside):
        (one,) = found.asserted
        assert one.cause.effect == "auxiliary_load"
    mine, other = (f.asserted[0].figures["power_w"].value for f in (alone, beside))
    assert other == pytest.approx(mine, rel=0.05)


def test_a_log_that_shows_nothing_of_a_load_has_no_evidence_of_one(tmp_path):
    felt = {"speed_mps": 0.01, "accel_x_mps2": 0.1}
    blind = driven(tmp_path / "felt.csv", "udds[0:340]", 0.0, 3, felt)
    engine = Engine([problem_of(blind.log, CAR)])
    probe = Probe(engine, descent.of_tolerances(engine), LOAD)
    time = blind.log["time_s"]
    profile = probe.profile(0, "time_s", time, 20)
    assert profile.evidence == 0.0
    assert probe.with_noise(profile, 0, time) == 0.0


def test_a_probe_stays_within_what_a_figure_may_be(tmp_path):
    """What is small for the vehicle of the log is too much for that of the file."""
    log = driven(tmp_path / "log.csv", "udds[0:340]", 0.0, 3)
    engine = Engine([problem_of(log.log, CAR)])
    fit = descent.of_tolerances(engine)
    wide, usual = Probe(engine, fit, LOAD, 1e9), Probe(engine, fit, LOAD)
    for a, b in zip(wide.signal, usual.signal, strict=True):
        np.testing.assert_allclose(a, b, rtol=0.05, atol=0.05 * np.abs(b).max())
