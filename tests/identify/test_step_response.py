"""Damping, friction and inertia from three figures and from step logs."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcc_sim.errors import InputError
from rcc_sim.identify.step_response import (
    damping_and_inertia,
    fit_step,
    fit_time_constant,
)

B, J, T_C = 1.17e-5, 2.3e-6, 0.0012
POSITIVE = st.floats(1e-3, 1e3)


def test_the_papers_figures_give_1_271e_5_and_2_492e_6():
    found = damping_and_inertia(527, 0.0067, 0.196)
    assert found.B == pytest.approx(1.2713e-5, rel=1e-4)
    assert found.J == pytest.approx(2.4918e-6, rel=1e-4)


@given(speed=POSITIVE, torque=POSITIVE, T=POSITIVE)
def test_relative_variances_add(speed, torque, T):
    found = damping_and_inertia(
        speed,
        torque,
        T,
        speed_sd=0.01 * speed,
        torque_sd=0.02 * torque,
        time_constant_sd=0.03 * T,
    )
    assert found.B_sd / found.B == pytest.approx(math.hypot(0.01, 0.02), rel=1e-5)
    assert found.J_sd / found.J == pytest.approx(math.hypot(0.01, 0.02, 0.03), rel=1e-5)
    assert found.J_budget["time_constant"] == pytest.approx(9 / 14, rel=1e-4)


@pytest.mark.parametrize("closed", [None, True])
def test_the_trap_of_the_closed_loop_is_told(closed):
    assert "open loop" in damping_and_inertia(1, 1, 1, closed_loop=closed).warnings[0]
    assert not damping_and_inertia(1, 1, 1, closed_loop=False).warnings


@pytest.mark.parametrize("figures", [(0, 1, 1), (1, -1, 1), (1, 1, float("inf"))])
def test_figures_must_be_positive(figures):
    with pytest.raises(InputError):
        damping_and_inertia(*figures)


def simulated(levels, *, closed, hold=2.0, dt=5e-4):
    """Wheels-free steps, exactly as J ω̇ = τ − B ω − T_C sgn ω: time, speed, torque."""
    n = int(hold / dt) * len(levels)
    omega, tau = np.zeros(n), np.zeros(n)
    w = integral = 0.0
    for i in range(n):
        ref = levels[int(i * dt / hold)]
        if closed:
            integral = integral + 3e-4 * (ref - w) * dt if ref else 0.0
            drive = min(max(2e-5 * (ref - w) + integral, -0.02), 0.02) if ref else 0.0
        else:
            drive = B * ref + T_C * np.sign(ref)
        omega[i], tau[i] = w, drive
        if w == 0 and abs(drive) <= T_C:
            continue
        way = np.sign(w) if w else np.sign(drive)
        final = (drive - T_C * way) / B
        new = final + (w - final) * math.exp(-B * dt / J)
        w = 0.0 if new * way < 0 else new
    return np.arange(n) * dt, omega, tau


def logged(run, rate_hz, *, seed, speed_noise=1.0, torque_noise=2e-4):
    """Return the run as a log: jittered, noisy, with rows lost and NaN."""
    rng = np.random.default_rng(seed)
    t, omega, tau = run
    rows = np.arange(0, t[-1], 1 / rate_hz)
    rows = np.clip(rows + rng.uniform(-0.2, 0.2, rows.size) / rate_hz, 0, t[-1])
    rows = rows[rng.random(rows.size) > 0.05]
    near = np.searchsorted(t, rows)
    w = omega[near] + speed_noise * rng.standard_normal(rows.size)
    w[rng.random(rows.size) < 0.01] = np.nan
    return rows, w, tau[near] + torque_noise * rng.standard_normal(rows.size)


STAIRS = [0, 200, 400, 500, 300, 0]
BOTH_WAYS = [0, 300, -300, 500, -500, 0]
RUNS = {
    (name, closed): simulated(levels, closed=closed)
    for name, levels in (("stairs", STAIRS), ("both_ways", BOTH_WAYS))
    for closed in (True, False)
}


@pytest.mark.parametrize("rate_hz", [50, 100, 1000])
@pytest.mark.parametrize("run", RUNS.values(), ids=[f"{n}-{c}" for n, c in RUNS])
def test_a_log_gives_back_damping_friction_and_inertia(run, rate_hz):
    found = fit_step(*logged(run, rate_hz, seed=rate_hz))
    assert found.converged
    assert found.identifiable
    assert found.steady_states == 4
    assert found.B == pytest.approx(B, abs=4 * found.B_sd)
    assert found.T_C == pytest.approx(T_C, abs=4 * found.T_C_sd)
    assert found.J == pytest.approx(J, abs=4 * found.J_sd)
    assert (found.B, found.J) == pytest.approx((B, J), rel=0.06)
    assert found.r_squared_steady > 0.99
    assert found.r_squared_transient > 0.98
    assert found.correlation[0][1] < -0.8


def test_ten_rows_a_second_serve_for_the_drag():
    found = fit_step(*logged(RUNS["stairs", True], 10, seed=5))
    assert found.B == pytest.approx(B, abs=4 * found.B_sd)
    assert pytest.approx(J, abs=4 * found.J_sd) == found.J
    assert any("log faster" in text for text in found.warnings)


def test_intervals_cover_the_truth():
    hits = []
    for seed in range(100):
        found = fit_step(*logged(RUNS["stairs", False], 100, seed=seed))
        z = (found.B - B) / found.B_sd, (found.T_C - T_C) / found.T_C_sd
        hits.append([abs(x) < 1.645 for x in (*z, (found.J - J) / found.J_sd)])
    assert np.all(np.mean(hits, axis=0) >= 0.8)
    assert np.all(np.mean(hits, axis=0)[:2] <= 0.98)


def test_one_steady_speed_cannot_tell_viscous_from_coulomb():
    run = simulated([0, 500, 0], closed=True)
    found = fit_step(*logged(run, 100, seed=0))
    assert not found.identifiable
    assert math.isinf(found.B_sd)
    assert math.isinf(found.T_C_sd)
    assert found.T_C == 0
    assert found.drag == pytest.approx(B * 500 + T_C, rel=0.01)
    assert pytest.approx(J, abs=2 * found.J_sd) == found.J
    assert "second speed" in found.warnings[0]


def test_transients_that_ignore_the_torque_leave_the_inertia_unknown():
    t, omega, _ = logged(RUNS["stairs", True], 100, seed=0)
    steady = np.interp(
        t, [0, 2, 2, 4, 4, 6, 6, 8, 8, 12], [0, 0, 2, 2, 4, 4, 5, 5, 3, 0]
    )
    found = fit_step(t, omega, B * 100 * steady + 2e-4 * np.sin(50 * t))
    assert found.J > 0
    assert found.J_sd > 0.1 * found.J


def test_a_purely_viscous_motor_has_no_friction():
    t, omega, tau = RUNS["stairs", False]
    way = np.sign(omega)
    found = fit_step(*logged((t, omega, tau - T_C * way), 100, seed=1))
    assert found.T_C == pytest.approx(0, abs=4 * found.T_C_sd)


def test_the_wrong_unit_is_named_as_the_likely_cause():
    t, omega, tau = logged(RUNS["stairs", True], 100, seed=0)
    with pytest.raises(InputError, match="100 % of the samples are below") as caught:
        fit_step(t, omega / 200, tau)
    assert "gearing or unit?" in caught.value.hint


def test_a_turned_sign_of_the_torque_is_named():
    t, omega, tau = logged(RUNS["stairs", True], 100, seed=0)
    with pytest.raises(InputError, match="against the motion"):
        fit_step(t, omega, -tau)


def test_a_log_that_never_settles_is_refused():
    t = np.arange(0, 10, 0.01)
    with pytest.raises(InputError, match=r"no stretch of 0\.2 s"):
        fit_step(t, 300 * np.sin(3 * t), np.cos(3 * t))


def test_speed_alone_gives_the_time_constant_of_the_open_loop():
    t, omega, _ = logged(RUNS["stairs", False], 100, seed=2)
    found = fit_time_constant(t, omega, closed_loop=False)
    assert found.T == pytest.approx(J / B, rel=0.02)
    assert found.inertia_over_damping == found.T
    assert not found.warnings


def test_speed_alone_in_a_closed_loop_says_nothing_of_the_motor():
    t, omega, _ = logged(RUNS["stairs", True], 100, seed=2)
    found = fit_time_constant(t, omega)
    assert found.inertia_over_damping is None
    assert any("overshoots" in text for text in found.warnings)
    assert found.T < 0.5 * J / B
