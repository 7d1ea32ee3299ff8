"""Yaw inertia from a bifilar pendulum."""

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rcc_sim.errors import InputError
from rcc_sim.identify.bifilar import lengthening, oscillation_period, yaw_inertia
from rcc_sim.identify.pendulum import swing_period

PAPER = {"m": 3.78, "T": 0.589, "d": 0.535, "h": 0.60}
SMALL = st.floats(0.05, 5.0)


def test_the_papers_inputs_give_0_0389_and_not_the_printed_0_0382():
    assert yaw_inertia(**PAPER).I_z == pytest.approx(0.0389, abs=1e-4)


@given(m=SMALL, T=SMALL, d=SMALL, h=SMALL)
def test_relative_variance_of_a_power_law_is_the_sum_of_its_inputs(m, T, d, h):
    found = yaw_inertia(
        m, T, d, h, m_sd=0.01 * m, T_sd=0.02 * T, d_sd=0.01 * d, h_sd=0.03 * h
    )
    parts = {"m": 0.01**2, "T": 0.04**2, "d": 0.02**2, "h": 0.03**2}
    total = sum(parts.values())
    assert found.sd / found.I_z == pytest.approx(math.sqrt(total), rel=1e-5)
    assert found.budget == pytest.approx(
        {k: v / total for k, v in parts.items()}, rel=1e-4
    )


@given(k=st.floats(0.1, 10))
def test_inertia_grows_with_the_square_of_the_period(k):
    scaled = yaw_inertia(**PAPER | {"T": k * PAPER["T"]})
    assert scaled.I_z == pytest.approx(k**2 * yaw_inertia(**PAPER).I_z)


@given(I_z=st.floats(1e-3, 1.0), amplitude=st.floats(1e-4, 1.0))
def test_the_correction_for_amplitude_undoes_the_exact_period(I_z, amplitude):
    T = swing_period(I_z, m=3.78, d=0.535, h=0.60, amplitude=amplitude)
    found = yaw_inertia(3.78, T, 0.535, 0.60, amplitude=amplitude)
    assert found.I_z == pytest.approx(I_z, rel=1e-9)


def test_the_exact_period_is_that_of_the_integrated_equation_of_motion():
    from scipy.integrate import solve_ivp

    I_z, m, a, h, start, g = 0.0389, 3.78, 0.2675, 0.60, 0.8, 9.80665

    def rate(_, y):
        z = math.sqrt(h**2 - 2 * a**2 * (1 - math.cos(y[0])))
        s = a**2 * math.sin(y[0]) / z  # -dz/dtheta
        ds = a**2 * math.cos(y[0]) / z + s**2 / z
        M = I_z + m * s**2
        return [y[1], -(m * g * s + m * s * ds * y[1] ** 2) / M]

    def turned(_, y):
        return y[0]

    turned.terminal, turned.direction = True, -1
    found = solve_ivp(rate, (0, 2), [start, 0], events=turned, rtol=1e-10, atol=1e-12)
    exact = swing_period(I_z, m=m, d=2 * a, h=h, amplitude=start)
    assert 4 * found.t_events[0][0] == pytest.approx(exact, rel=1e-7)


def test_the_carrier_is_taken_off():
    plate, car = 0.01, 0.0389
    T_plate = swing_period(plate, m=0.5, d=0.535, h=0.60, amplitude=1e-6)
    T_both = swing_period(plate + car, m=4.28, d=0.535, h=0.60, amplitude=1e-6)
    found = yaw_inertia(4.28, T_both, 0.535, 0.60, tare_mass=0.5, tare_period=T_plate)
    assert found.I_z == pytest.approx(car)
    assert found.I_tare == pytest.approx(plate)


def test_two_repeats_carry_students_factor():
    found = yaw_inertia(**PAPER | {"T": [0.588, 0.590]})
    assert found.T_sd == pytest.approx(1.837 * 0.001, rel=1e-3)


def test_a_stated_sd_is_a_floor_and_too_large_a_scatter_is_told():
    agreed = yaw_inertia(**PAPER | {"T": [0.589, 0.589]}, T_sd=0.004)
    assert agreed.T_sd == pytest.approx(0.004 / math.sqrt(2))
    odd = yaw_inertia(**PAPER | {"T": [0.55, 0.589, 0.62]}, T_sd=0.001)
    assert any("scatter" in text for text in odd.warnings)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"h": [0.60, 0.65]}, "tilted"),
        ({"d": [0.50, 0.57]}, "parallel"),
        ({"amplitude": 0.5}, "20°"),
        ({}, "no uncertainty"),
    ],
)
def test_what_a_reader_should_know_is_told(change, word):
    assert any(word in text for text in yaw_inertia(**PAPER | change).warnings)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"T": 0.0}, "period"),
        ({"m": float("nan")}, "m"),
        ({"T": []}, "T"),
        ({"T_sd": -1.0}, "T_sd"),
        ({"T": [0.5, 0.6], "T_sd": [0.1, 0.1, 0.1]}, "T_sd"),
        ({"amplitude": 10.0}, "amplitude"),
        ({"tare_mass": 5.0, "tare_period": 0.3}, "tare_mass"),
        ({"tare_mass": 1.0}, "tare_period"),
        ({"tare_mass": 3.0, "tare_period": 2.0}, "tare_period"),
        ({"d": [0.1, 2.0], "h": 0.5}, "h"),
        ({"d": [0.5, 0.5, 0.9]}, "d: should be one length, or two"),
        ({"h": [1.0, 1.0, 1.0]}, "h: should be one length, or two"),
    ],
)
def test_bad_input_names_the_argument(change, word):
    with pytest.raises(InputError, match=f"^{word}"):
        yaw_inertia(**PAPER | change)


def test_figures_alone_load_neither_numpy_nor_scipy():
    code = (
        "import sys; from rcc_sim.identify import bifilar, step_response, cg;"
        "bifilar.yaw_inertia(3.78, 0.589, 0.535, 0.6, T_sd=0.001);"
        "step_response.damping_and_inertia(527, 0.0067, 0.196);"
        "sys.exit('numpy' in sys.modules or 'scipy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def gyro_log(
    rate_hz, *, seed, noise=0.05, T=0.589, zeta=0.02, releases=(3.0, 16.0), lost=0.1
):
    """Still, released, swinging, stopped by hand; jittered, with rows lost and NaN."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 29, 1 / rate_hz)
    t += rng.uniform(-0.3, 0.3, t.size) / rate_hz
    rate = np.full(t.size, 0.03)
    omega = 2 * np.pi / T
    for start in releases:
        x = t - start
        on = (x > 0) & (x < 9)
        damped = np.exp(-zeta * omega * x) * np.sin(omega * np.sqrt(1 - zeta**2) * x)
        rate[on] += 1.5 * damped[on]
    rate += noise * rng.standard_normal(t.size)
    rate[rng.random(t.size) < 0.01] = np.nan
    keep = rng.random(t.size) > lost
    return t[keep], rate[keep]


@pytest.mark.parametrize("rate_hz", [10, 20, 100, 400])
@pytest.mark.parametrize("noise", [0.01, 0.1])
def test_each_swing_of_a_log_gives_a_period(rate_hz, noise):
    found = oscillation_period(*gyro_log(rate_hz, seed=rate_hz, noise=noise))
    assert len(found.swings) == 2
    assert found.T == pytest.approx(0.589, abs=max(4 * found.T_sd, 1e-4))
    assert found.T == pytest.approx(0.589, rel=0.01)
    assert found.damping_ratio == pytest.approx(0.02, abs=0.006)


def test_heavy_damping_lengthens_the_period_and_is_taken_off():
    log = gyro_log(100, seed=1, noise=0.003, zeta=0.12)
    swing = oscillation_period(*log).swings[0]
    assert swing.T_damped == pytest.approx(0.589 / math.sqrt(1 - 0.12**2), rel=1e-3)
    assert swing.T == pytest.approx(0.589, rel=1e-3)


def test_a_gap_of_three_periods_does_not_split_a_swing():
    t, rate = gyro_log(50, seed=2, noise=0.02)
    keep = (t < 5) | (t > 7)
    assert len(oscillation_period(t[keep], rate[keep]).swings) == 2


@settings(max_examples=8)
@given(scale=st.floats(1e-3, 1e3))
def test_the_period_does_not_depend_on_the_unit_of_the_rate(scale):
    t, rate = gyro_log(20, seed=3)
    same = oscillation_period(t, scale * rate)
    assert same.T == pytest.approx(oscillation_period(t, rate).T, rel=1e-6)


def test_intervals_of_the_period_cover_the_truth():
    inside = []
    for seed in range(100):
        found = oscillation_period(*gyro_log(50, seed=seed, releases=(3.0,)))
        inside.append(abs(found.T - 0.589) < 1.645 * found.T_sd)
    assert 0.8 <= np.mean(inside) <= 0.98


def test_periods_of_a_log_go_into_the_inertia():
    found = oscillation_period(*gyro_log(100, seed=4))
    car = yaw_inertia(3.78, found.periods, 0.535, 0.60, T_sd=found.period_sds)
    assert car.I_z == pytest.approx(0.03885, rel=0.005)


def hung(I_z, m, d, h, angle, drag, rate_hz=100):
    """Return the log of a car let go at an angle, by its equation of motion.

    The car rises as it turns: z² = h² - d²/2 (1 - cos θ) below the ceiling.
    """
    ab = d * d / 4

    def motion(_, y):
        theta, rate = y
        z = math.sqrt(h * h - 2 * ab * (1 - math.cos(theta)))
        q = ab * math.sin(theta) / z  # dz/dθ, and its own change
        dq = (ab * math.cos(theta) + q * q) / z
        moved = m * 9.80665 * q + m * q * dq * rate * rate + drag * rate
        return rate, -moved / (I_z + m * q * q)

    t = np.arange(0.0, 15.0, 1 / rate_hz)
    swing = solve_ivp(motion, (0, 15), [angle, 0.0], t_eval=t, rtol=1e-9, atol=1e-11)
    still = np.zeros(2 * rate_hz)
    rate = np.concatenate([still, swing.y[1]])
    noise = 0.01 * np.random.default_rng(1).standard_normal(rate.size)
    return np.arange(rate.size) / rate_hz, rate + noise


@pytest.mark.parametrize(("angle", "within"), [(0.05, 1e-3), (0.2, 1e-3), (0.35, 4e-3)])
@pytest.mark.parametrize("drag", [0.002, 0.02])
@pytest.mark.parametrize(("d", "h"), [(0.535, 0.6), (0.3, 1.2)])
def test_a_log_of_wide_swings_tells_the_inertia_as_one_of_narrow_ones_does(
    angle, within, drag, d, h
):
    log = hung(0.0389, 3.78, d, h, angle, drag)
    about = oscillation_period(*log).T
    found = oscillation_period(*log, lengthening(3.78, about, d, h))
    car = yaw_inertia(3.78, found.periods, d, h, T_sd=found.period_sds)
    assert car.I_z == pytest.approx(0.0389, abs=within * 0.0389 + 3 * car.sd)


@pytest.mark.parametrize(
    "rate",
    [
        np.zeros(500),
        np.linspace(0, 1, 500),
        np.random.default_rng(0).standard_normal(500),
        np.cumsum(np.random.default_rng(1).standard_normal(500)),
    ],
    ids=["still", "ramp", "noise", "walk"],
)
def test_a_log_without_a_swing_is_refused_with_what_was_found(rate):
    with pytest.raises(InputError, match=r"no free oscillation in 9\.98 s") as caught:
        oscillation_period(0.02 * np.arange(500), rate)
    assert caught.value.hint


def test_time_that_runs_back_is_refused():
    with pytest.raises(InputError, match="strictly increasing"):
        oscillation_period([0, 1, 2, 1, 3, 4, 5, 6, 7], np.ones(9))
    with pytest.raises(InputError, match="8 rows"):
        oscillation_period(np.arange(20.0), np.full(20, np.nan))
