"""A heater that switches on and off is a load, not a noise that remembers."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.deliver import acting
from rcc_sim.diagnose.profiles.partition import segments
from rcc_sim.diagnose.profiles.switched import FIRST, sharpened
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from rcc_sim.units import G

CAR = load_vehicle("tesla_model_3")
NOISE = {"speed_mps": 0.01, "battery_voltage_v": 0.1, "battery_current_a": 0.5}


def driven(folder, heater, torque=False):
    """A log of a town drive over a rough road, with a heater's power [W] over time.

    Where the torque is logged, the road's roughness is in it, and not in the load.
    """
    rng = np.random.default_rng(8)
    cycle = parse_cycle("udds[0:600]")
    time = np.arange(0.0, 600.0, 0.1)
    gust = np.convolve(rng.normal(0, 1, len(time)), np.exp(-np.arange(0, 5, 0.1)))
    gust *= 150.0 / gust.std()  # N, of the road and the wind
    speed = np.interp(time, cycle.time_s, cycle.speed_mps)
    speed = np.convolve(np.pad(speed, 5), np.ones(11) / 11, "valid")
    slope = gust[: len(time)] / (CAR.body.mass_kg.value * G)
    made = Trace(
        {
            "time_s": time,
            "speed_mps": speed,
            "aux_power_w": heater(time),
            "slope": slope,
        },
        name="made",
    )
    seen = replay(CAR, drive_of(made, CAR))
    noise = NOISE | ({"motor_torque_nm": 1.5} if torque else {})
    log = {n: seen[n] + rng.normal(0, s, len(time)) for n, s in noise.items()}
    path = folder / "log.csv"
    table = np.column_stack([time, *log.values()])
    head = ",".join(["time_s", *log])
    np.savetxt(path, table, fmt="%.6g", delimiter=",", header=head, comments="")
    return open_log(path, CAR)


LOAD = "effects.auxiliary_load.power_w"
HEATERS = {
    "once": lambda t: np.where((t > 150) & (t < 400), 3000.0, 0.0),
    "by turns": lambda t: np.where((t % 200) < 110, 3500.0, 0.0),
}


def judged(found, heater):
    """The load's estimate, its profile's correlation with the heater, the true mean."""
    (one,) = found.asserted
    assert one.cause.effect == "auxiliary_load"
    time = np.arange(0.0, 600.0, 0.1)
    alike = np.corrcoef(one.cause.profiles[0].at(time), heater(time))[0, 1]
    true = CAR.figures()[LOAD].value + heater(time).mean()
    return one, alike, true


@pytest.mark.parametrize(
    ("heater", "torque"),
    [
        pytest.param(
            *(heater, torque),
            id=f"{name} by {'torque' if torque else 'speed'}",
            marks=[pytest.mark.thorough] * (torque != (name == "once")),
        )
        for name, heater in HEATERS.items()
        for torque in (False, True)
    ],
)
def test_a_heater_that_switches_is_named_with_its_mean(tmp_path, heater, torque):
    found = diagnose([driven(tmp_path, heater, torque)], CAR)
    one, alike, true = judged(found, heater)
    assert alike > 0.95
    told = one.figures["power_w"]
    assert told.low < true < told.high
    assert told.value == pytest.approx(true, rel=0.1)
    assert told.high - told.low < 0.7 * true
    written, _ = acting(found, one.cause)
    assert told.most == pytest.approx(written.max(), rel=0.02)
    assert told.least < told.value < told.most
    assert found.status == "explained"


def test_the_mean_of_a_short_pulse_is_over_the_drive_and_not_over_its_knots(tmp_path):
    def pulse(t):
        return np.where((t > 200) & (t < 230), 6000.0, 0.0)

    one, alike, true = judged(diagnose([driven(tmp_path, pulse, True)], CAR), pulse)
    assert alike > 0.95
    assert one.figures["power_w"].value == pytest.approx(true, rel=0.1)


def test_a_heater_that_wanes_is_told_with_its_course(tmp_path):
    def waning(t):
        return 500.0 + 4500.0 * np.exp(-t / 150)

    one, alike, true = judged(diagnose([driven(tmp_path, waning)], CAR), waning)
    assert alike > 0.95
    assert one.figures["power_w"].low < true < one.figures["power_w"].high


def test_a_rough_road_alone_is_no_load(tmp_path):
    assert not diagnose([driven(tmp_path, np.zeros_like)], CAR).asserted


SMALL = load_vehicle("rcc")
LEAST_W, LAMP_W = 1.0, 4.0


def lamp(time, rng, lamp_w):
    """On and off every three to nine seconds."""
    return LEAST_W + lamp_w * (
        np.searchsorted(np.cumsum(rng.uniform(3, 9, 40)), time) % 2
    )


def driven_small(folder, seed, lamp_w, load=lamp):
    """75 s of a small car with a load [W] over time."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 75.0, 0.02)
    speed = 2.0 + 1.2 * np.sin(time / 4) + 0.6 * np.sin(time / 1.7)
    aux = load(time, rng, lamp_w)
    made = Trace({"time_s": time, "speed_mps": speed, "aux_power_w": aux}, name="made")
    seen = replay(SMALL, drive_of(made, SMALL))
    noise = {"speed_mps": 0.005, "battery_voltage_v": 0.02, "battery_current_a": 0.15}
    log = {n: seen[n] + rng.normal(0, s, len(time)) for n, s in noise.items()}
    path = folder / "log.csv"
    table = np.column_stack([time, *log.values()])
    head = ",".join(["time_s", *log])
    np.savetxt(path, table, fmt="%.6g", delimiter=",", header=head, comments="")
    return open_log(path, SMALL), aux


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(s, marks=pytest.mark.thorough) for s in (2, 3))]
)
def test_a_lamp_that_switches_every_few_seconds_is_named_level_by_level(tmp_path, seed):
    log, aux = driven_small(tmp_path, seed, LAMP_W)
    found = diagnose([log], SMALL)
    (one,) = found.asserted
    assert one.cause.effect == "auxiliary_load"
    told = one.figures["power_w"]
    assert told.low < aux.mean() < told.high
    time = np.arange(0.0, 75.0, 0.02)
    assert np.corrcoef(one.cause.profiles[0].at(time), aux)[0, 1] > 0.9
    assert told.most - told.least == pytest.approx(LAMP_W, abs=1.0)


def test_a_lamp_that_stays_on_is_no_load_that_switches(tmp_path):
    log, _ = driven_small(tmp_path, 1, 0.0)
    assert all(not a.cause.profiles for a in diagnose([log], SMALL).asserted)


def pulses(time, rng, lamp_w):
    return lamp_w * (time % 6.0 < 2.0)


def test_a_load_that_pulses_is_told_with_its_course(tmp_path):
    log, aux = driven_small(tmp_path, 5, 6.0, pulses)
    (one,) = diagnose([log], SMALL).asserted
    assert one.cause.effect == "auxiliary_load"
    time = np.arange(0.0, 75.0, 0.02)
    assert np.corrcoef(one.cause.profiles[0].at(time), aux)[0, 1] > 0.95
    assert one.figures["power_w"].value == pytest.approx(aux.mean(), rel=0.1)


def test_pulses_are_found_once_what_they_hide_in_is_known_without_them():
    rng = np.random.default_rng(3)
    heater = np.where(np.arange(990) % 40 < 12, 4000.0, 0.0)
    value = heater + rng.normal(0, 300, len(heater))
    told = np.full(len(value), 1 / value.var())
    # each change gains too little
    assert len(segments(value, told, 2, 10.0).edges) < 20
    times = sharpened(value, told, segments(value, told, 2, FIRST).edges)
    assert times == pytest.approx(value.var() / 300**2, rel=0.2)
    found = segments(value, told * times, 2, 10.0).edges
    true = np.flatnonzero(np.diff(heater)) + 1
    np.testing.assert_array_equal(found[1:-1], true)


def test_a_heater_that_cools_each_time_it_was_on_is_followed(tmp_path):
    # by levels alone it would come out in stairs, at a correlation of 0.977
    def heater(t):
        return np.where(t % 150 < 90, 4000 * np.exp(-(t % 150) / 40), 0.0)

    found = diagnose([driven(tmp_path, heater, torque=True)], CAR)
    one, alike, true = judged(found, heater)
    assert alike > 0.99
    assert one.figures["power_w"].value == pytest.approx(true, rel=0.03)


def test_a_heater_that_swings_twice_a_minute_is_followed(tmp_path):
    # a noise that remembers would smooth half of it away
    def heater(t):
        return 1500 + 4000 * np.exp(-t / 150) + 1200 * np.sin(2 * np.pi * t / 30)

    found = diagnose([driven(tmp_path, heater, torque=True)], CAR)
    one, alike, true = judged(found, heater)
    assert alike > 0.98
    assert one.figures["power_w"].value == pytest.approx(true, rel=0.03)


@pytest.mark.parametrize(
    "torque",
    [pytest.param(False, marks=pytest.mark.thorough), True],
    ids=["by speed", "by torque"],
)
def test_what_would_be_less_than_no_load_is_left_and_placed(tmp_path, torque):
    def heater(t):
        generator = np.where((t > 300) & (t < 330), 7000.0, 0.0)
        return np.where(t < 100, 4000 * np.exp(-t / 60), 500.0) - generator

    found = diagnose([driven(tmp_path, heater, torque)], CAR)
    (one,) = found.asserted
    assert one.cause.effect == "auxiliary_load"
    least, _ = acting(found, one.cause)
    assert least.min() >= 0
    assert found.status == "partly_explained"
    assert found.left.acts_as == "feed"
    (window,) = found.document()["unexplained"]["windows"]
    assert window["start_s"] == pytest.approx(300, abs=3)
    assert window["end_s"] == pytest.approx(330, abs=3)
