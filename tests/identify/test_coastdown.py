"""Road load from coast-downs, simulated and measured."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rcc_sim.errors import InputError
from rcc_sim.identify.coastdown import fit_coastdown
from rcc_sim.units import G

CAR = {"A": 1.2, "B": 0.25, "C": 0.05, "m": 3.78}
DART = (
    Path(__file__).parents[2].parent
    / "shared/data/real_rc/dart_jetracer/19_step_input_data"
)


def coast(A, B, C, m, *, v0, slope=0.0, inertia=None):
    """Time and speed of a coast from v0 to 2 % of it, by an independent solver."""

    def rate(_, v):
        return -(A + B * v + C * v**2 + m * G * np.sin(np.arctan(slope))) / (
            inertia or m
        )

    def slow(_, v):
        return v[0] - 0.02 * v0

    slow.terminal = True
    run = solve_ivp(
        rate, (0, 1000), [v0], events=slow, dense_output=True, rtol=1e-8, atol=1e-9
    )
    return run.t[-1], run.sol


def log(runs, *, seed, noise=0.05, rate_hz=20, rho=0.0, lost=0.05):
    """Drives up to speed and coasts, run after run: time, speed, drive."""
    rng = np.random.default_rng(seed)
    t, v, drive, start = [], [], [], 0.0
    for end, speed in runs:
        up, down = np.arange(0, 5, 1 / rate_hz), np.arange(0, end, 1 / rate_hz)
        t += [start + up, start + 5 + down]
        v += [speed(0.0)[0] * up / 5, speed(down)[0]]
        drive += [np.ones(up.size), np.zeros(down.size)]
        start += 6 + end
    t, v, drive = map(np.concatenate, (t, v, drive))
    error = rng.standard_normal(t.size)
    for i in range(1, t.size if rho else 0):
        error[i] = rho * error[i - 1] + np.sqrt(1 - rho**2) * error[i]
    keep = rng.random(t.size) > lost
    return t[keep], (v + noise * error)[keep], drive[keep]


@pytest.fixture(scope="module")
def pair():
    return [coast(**CAR, v0=12.0)] * 2


def test_two_coasts_give_the_road_load_back(pair):
    t, v, drive = log(pair, seed=0, noise=0.01)
    found = fit_coastdown(t, v, CAR["m"], drive=drive, slope=0.0)
    assert found.converged
    assert found.terms == ("A", "B", "C")
    for name in found.terms:
        term = getattr(found, name)
        assert term.value == pytest.approx(CAR[name], abs=4 * term.sd)
        assert term.value == pytest.approx(CAR[name], rel=0.05)
    assert found.C_rr.value == pytest.approx(found.A.value / (3.78 * G))
    assert found.C_dA.value == pytest.approx(2 * found.C.value / 1.2)


@pytest.mark.parametrize("rho", [pytest.param(0.0, marks=pytest.mark.thorough), 0.9])
def test_intervals_cover_the_truth_under_correlated_noise(pair, rho):
    hits = []
    for seed in range(100):
        t, v, drive = log(pair, seed=seed, rho=rho)
        found = fit_coastdown(
            t, v, CAR["m"], drive=drive, slope=0.0, terms=("A", "B", "C")
        )
        terms = [(found.A, "A"), (found.B, "B"), (found.C, "C")]
        hits.append([term.low < CAR[name] < term.high for term, name in terms])
    assert np.all(np.mean(hits, axis=0) >= 0.8)
    assert np.all(np.mean(hits, axis=0) <= 0.98)


def test_both_directions_tell_the_slope_from_the_rolling_resistance():
    ways = (1, -1, 1, -1)
    runs = [coast(199, 9.26, 0.393, 3175, v0=35.0, slope=0.003 * way) for way in ways]
    t, v, drive = log(runs, seed=1, rate_hz=10)
    found = fit_coastdown(t, v, 3175, drive=drive, direction=ways)
    assert found.slope.value == pytest.approx(0.003, rel=0.01)
    assert found.A.low < 199 < found.A.high
    blind = fit_coastdown(t, v, 3175, drive=drive)
    assert any("one direction" in text for text in blind.warnings)


def test_a_known_slope_is_taken_off_as_slope_and_as_elevation():
    end, speed = coast(199, 9.26, 0.393, 3175, v0=35.0, slope=0.004)
    t, v, drive = log([(end, speed)], seed=2, rate_hz=10)
    by_slope = fit_coastdown(t, v, 3175, drive=drive, slope=0.004)
    distance = np.concatenate([[0], np.cumsum((v[1:] + v[:-1]) / 2 * np.diff(t))])
    by_height = fit_coastdown(t, v, 3175, drive=drive, elevation_m=0.004 * distance)
    assert by_slope.A.value == pytest.approx(199, abs=4 * by_slope.A.sd)
    assert by_height.A.value == pytest.approx(by_slope.A.value, rel=0.01)


def test_what_turns_counts_as_mass_but_not_as_weight():
    run = coast(**CAR, v0=12.0, slope=0.01, inertia=CAR["m"] + 0.4)
    t, v, drive = log([run], seed=3, noise=0.01)
    found = fit_coastdown(
        t, v, CAR["m"], equivalent_inertia_kg=0.4, drive=drive, slope=0.01
    )
    assert found.A.value == pytest.approx(CAR["A"], rel=0.05)


def test_a_small_range_of_speed_leaves_the_square_out_and_says_so():
    run = coast(1.2, 0.25, 0.02, 3.78, v0=2.0)
    t, v, drive = log([run, run], seed=4, rate_hz=10)
    found = fit_coastdown(t, v, 3.78, drive=drive)
    assert "C" not in found.terms
    assert found.C.value == 0
    assert found.C.low < 0.02 < found.C.high
    assert found.C_dA is None
    assert any("C was left out (not told from 0" in text for text in found.warnings)


def test_a_negative_square_is_refused_as_drag():
    run = coast(1.2, 0.9, -0.06, 3.78, v0=6.0)
    t, v, drive = log([run] * 3, seed=5, noise=0.01)
    found = fit_coastdown(t, v, 3.78, drive=drive)
    assert "C" not in found.terms
    assert any("comes out negative" in text for text in found.warnings)
    forced = fit_coastdown(t, v, 3.78, drive=drive, terms=("A", "B", "C"))
    assert forced.C.value == pytest.approx(-0.06, rel=0.1)
    assert forced.C_dA is None


def test_without_a_drive_signal_the_long_decelerations_are_found(pair):
    t, v, drive = log(pair, seed=6)
    alone = fit_coastdown(t, v, CAR["m"], terms=("A", "C"))
    told = fit_coastdown(t, v, CAR["m"], drive=drive, terms=("A", "C"))
    assert len(alone.stretches) == 2
    assert alone.A.value == pytest.approx(told.A.value, rel=0.05)
    assert "no drive signal" in alone.warnings[0]


def test_uncertain_mass_widens_every_coefficient(pair):
    t, v, drive = log(pair, seed=7)
    found = fit_coastdown(t, v, 3.78, drive=drive, mass_sd_kg=0.378)
    assert found.A.sd > 0.1 * found.A.value


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mass_kg": 0.0}, "mass_kg"),
        ({"slope": 0.0, "elevation_m": np.zeros(3)}, "only one"),
        ({"terms": ("D",)}, "terms"),
        ({"direction": (1, 1, 1)}, "one entry per coast"),
        ({"direction": (1, 0)}, r"\+1 or -1"),
        ({"drive": np.ones(3)}, "one value per row"),
    ],
)
def test_bad_input_is_refused(pair, change, message):
    t, v, drive = log(pair, seed=8)
    with pytest.raises(InputError, match=message):
        fit_coastdown(t, v, **{"mass_kg": 3.78, "drive": drive} | change)


@pytest.mark.parametrize("noise", [0.01, 0.2])
def test_a_log_of_nothing_but_coasts_has_a_drive_of_nothing_but_noise(pair, noise):
    t, v, drive = log(pair, seed=9)
    still = drive == 0
    heard = noise * np.random.default_rng(1).standard_normal(still.sum())
    found = fit_coastdown(t[still], v[still], 3.78, drive=heard)
    assert len(found.stretches) == 2
    assert found.A.value == pytest.approx(CAR["A"], rel=0.1)


def test_coasts_that_disagree_are_told_and_those_that_agree_are_not(pair):
    way = {"rate_hz": 50, "noise": 0.02, "lost": 0.0}
    there, back = (coast(**CAR, v0=12.0, slope=s) for s in (0.02, -0.02))
    t, v, drive = log([there, back], seed=4, **way)
    told = fit_coastdown(t, v, 3.78, drive=drive).warnings
    assert any("coasts that disagree" in text for text in told)
    both = fit_coastdown(t, v, 3.78, drive=drive, direction=(1, -1))
    assert not any("disagree" in text for text in both.warnings)
    t, v, drive = log(pair, seed=4, **way)
    assert not any(
        "disagree" in text for text in fit_coastdown(t, v, 3.78, drive=drive).warnings
    )


def test_a_log_that_never_coasts_is_refused_with_what_was_found(pair):
    t, v, drive = log(pair, seed=9)
    with pytest.raises(InputError, match="no coast: none of 0") as caught:
        fit_coastdown(t, v, 3.78, drive=drive + 1)
    assert caught.value.hint
    with pytest.raises(InputError, match="never moves forwards"):
        fit_coastdown(t, -np.abs(v), 3.78)


def dart_logs():
    """Every DART log with a coast from more than 2 m/s: time, speed, drive."""
    for path in sorted(DART.glob("*.csv")):
        table = np.genfromtxt(path, delimiter=",", names=True)
        table = table[table["elapsed_time_sensors"] > 0]
        if np.max(table["vel_encoder"]) > 2:
            drive = table["throttle"] * table["safety_value"]
            yield table["elapsed_time_sensors"], table["vel_encoder"], drive


@pytest.mark.skipif(
    not DART.is_dir(), reason="the DART logs are not beside the project"
)
def test_a_real_car_slows_by_1_to_1_7_mps2_and_more_at_speed():
    m = 1.58
    for t, v, drive in dart_logs():
        found = fit_coastdown(t, v, m, drive=drive)
        assert found.converged
        at = [
            (found.A.value + found.B.value * x + found.C.value * x**2) / m
            for x in (0.5, 1.0, 2.0, 3.0)
        ]
        assert at == sorted(at)
        assert 1.0 < at[0] < at[-1] < 1.8
