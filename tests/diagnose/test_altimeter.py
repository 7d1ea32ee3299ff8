"""An altimeter that wanders is told as one, where anything tells; it is no drag."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.profiles import altimeter
from rcc_sim.diagnose.profiles.as_felt import as_felt, felt_slope
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.report.doubts import misread_sensors
from rcc_sim.report.verdict import verdict_of
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace, integral_of
from rcc_sim.units import G

CAR = load_vehicle("tesla_model_3")
LOAD = "effects.auxiliary_load.power_w"
MASS = 1830.0  # kg; of the body that a rough road pushes
NOISE = {"speed_mps": 0.02, "battery_voltage_v": 0.2, "battery_current_a": 0.5,
         "accel_x_mps2": 0.08, "elevation_m": 0.1}  # fmt: skip


def slowly(rng, n, sd, seconds):
    """What wanders with a standard deviation and over a time."""
    k = np.exp(-0.1 / seconds)
    return lfilter([sd * np.sqrt(1 - k * k)], [1, -k], rng.normal(size=n))


def driven(seed, wander, seconds, car=CAR, felt=True, bumps=0.02):
    """A drive over hills of a town, ten rows a second, and a receiver's heights."""
    rng = np.random.default_rng(seed)
    town = parse_cycle("udds[0:600]")
    t = np.arange(0.0, 600.0, 0.1)
    v = np.interp(t, town.time_s - town.time_s[0], town.speed_mps)
    s = integral_of(t, v)
    height = 12 * np.sin(s / 400) + 4 * np.sin(s / 130 + 1)
    slope = 12 / 400 * np.cos(s / 400) + 4 / 130 * np.cos(s / 130 + 1)
    road = Trace({"time_s": t, "speed_mps": v, "slope": slope}, name="road")
    out = replay(car, drive_of(road, car))
    rough = MASS * slowly(rng, len(t), bumps, 0.5) * v
    off = np.convolve(slowly(rng, len(t), wander, seconds), np.ones(50) / 50, "same")
    volts = out["battery_voltage_v"]
    true = {
        "speed_mps": v,
        "battery_voltage_v": volts,
        "battery_current_a": (out["battery_power_w"] + rough) / volts,
        "accel_x_mps2": np.gradient(v, t) + G * slope / np.sqrt(1 + slope**2),
        "elevation_m": height + off,
    }
    seen = {c: x + rng.normal(0, NOISE[c], len(t)) for c, x in true.items()}
    seen["speed_mps"] = np.maximum(seen["speed_mps"], 0.0)
    if not felt:
        del seen["accel_x_mps2"]
    return Trace({"time_s": t} | seen, name="drive"), float(np.std(off))


def told(log, car=CAR):
    found = diagnose([Logged(log, (), None)], car)
    wanders = [f for f in found.gap.findings if f.kind.endswith("wander")]
    return found, wanders


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wander", "seconds"),
    [pytest.param(0.8, 30.0, marks=pytest.mark.thorough), (2.0, 120.0)],
)
def test_heights_that_the_accelerometer_did_not_feel_are_off(wander, seconds):
    log, off = driven(1, wander, seconds)
    found, (one,) = told(log)
    assert (found.status, found.asserted) == ("no_gap", ())
    assert "accelerometer felt" in one.what
    assert ("DOUBT", f"elevation_m {one.what}; {one.action}") in misread_sensors(found)
    metres = float(one.what.split("some ")[1].split(" m")[0])
    assert 0.5 * off < metres < 3 * off


@pytest.mark.slow
def test_a_load_is_named_beside_them():
    more = CAR.changed(settings={LOAD: CAR.figures()[LOAD].value + 1500.0})
    found, wanders = told(driven(4, 1.0, 60.0, more)[0])
    assert [a.cause.effect for a in found.asserted] == ["auxiliary_load"]
    assert wanders


@pytest.mark.slow
def test_without_an_accelerometer_it_is_doubted_and_what_the_file_allows_is_none():
    log, _ = driven(1, 2.0, 120.0, felt=False)
    found, (one,) = told(log)
    assert (found.status, found.asserted) == ("unexplained", ())
    assert "a drag would do no better" in one.what
    assert "unless elevation_m wanders" in verdict_of(found.document())
    poor = CAR.changed(settings={"sensors.elevation_m.noise_sd": 3.0})
    found, (one,) = told(log, poor)
    assert (found.status, found.asserted) == ("no_gap", ())


@pytest.mark.slow
def test_heights_that_stay_are_not_doubted():
    found, wanders = told(driven(3, 0.0, 60.0)[0])
    assert (found.status, wanders) == ("no_gap", [])


@pytest.mark.slow
def test_a_hill_that_heights_do_not_show_leaves_the_rest_of_the_road_as_it_is():
    log, _ = driven(3, 0.0, 60.0, bumps=0.002)
    s = integral_of(log["time_s"], log["speed_mps"])
    flat = log["elevation_m"] - 14.0 * np.clip((s - 2000) / 500, 0.0, 1.0)
    hidden = Trace(log.columns | {"elevation_m": flat}, name="hill")
    engine = Engine([problem_of(hidden, CAR)])
    null = descent.fit(engine, {}, nuisance_knobs(engine.problems))
    slope = felt_slope(engine, null, 0)
    there = (s > 2100) & (s < 2400)
    assert slope.at(s[there]).mean() == pytest.approx(14.0 / 500, rel=0.3)
    far = (s < 1500) | (s > 3000)
    assert np.median(slope.at(s[far])) == pytest.approx(0.0, abs=0.25 * 14.0 / s[-1])


def test_a_road_on_which_a_log_is_less_likely_is_not_the_one_that_was_felt(monkeypatch):
    """A speed that read 3 % too little looked like heights that were off."""
    log, _ = driven(1, 2.0, 120.0)
    engine = Engine([problem_of(log, CAR)])
    assert as_felt(engine).wanders
    plain = descent.of_tolerances(engine)
    fit = descent.fit

    def worse(there, values, *rest):
        found = fit(there, values, *rest)
        return found if there is engine else replace(found, loglik=plain.loglik - 100)

    monkeypatch.setattr(descent, "fit", worse)
    kept = as_felt(engine)
    assert (kept.engine, kept.wanders) == (engine, {})
    assert kept.null.values == plain.values


@pytest.mark.parametrize(
    ("likelier", "felt", "dragged", "known"),
    [
        (25.0, None, None, True),  # clear by the noise of the fit
        (10.0, 200.0, 150.0, True),  # in doubt: by the noise that each leaves
        (10.0, 160.0, 150.0, False),
        (-1.0, None, None, False),  # never where a slope is no likelier
    ],
)
def test_what_the_accelerometer_felt_is_judged_sharply_in_doubt(
    monkeypatch, likelier, felt, dragged, known
):
    t = np.arange(0.0, 100.0, 0.1)
    log = {"time_s": t, "speed_mps": np.full(len(t), 10.0), "elevation_m": 0.1 * t}
    engine = Engine([problem_of(Trace(log, name="way"), CAR)])
    knots = np.linspace(0.0, 100.0, 12)
    small = 1e-3 * np.sin(knots)
    drag = Profile("drag", "time_s", knots, small, small, 100.0)

    class Weighed:
        def __init__(self, logs, fit, key):
            self.key = key

        def profile(self, log, along, x, count):
            return replace(drag, key=self.key, evidence=100.0 + likelier)

        def sharpest(self, profile, log, x, counts):
            return profile, dragged if self.key == "drag" else felt

    monkeypatch.setattr(altimeter, "Probe", Weighed)
    found = altimeter.wander(engine, None, drag, 100.0, 0)
    assert found.is_felt is known
