"""`inertia`, `step`, `coastdown`, `cg` as a user meets them."""

import json

import numpy as np
import pytest

from tests.program import rccsim


def answer(*args, stdin=""):
    done = rccsim(*args, "--json", stdin=stdin)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def table(**columns):
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(f"{x:.9g}" for x in row) for row in rows]
    return "\n".join([",".join(columns), *lines]) + "\n"


RIG = ("--mass", 3.78, "--spacing", 0.535, "--length", 0.60)


def test_inertia_of_the_paper_s_pendulum():
    found = answer("inertia", *RIG, "--period", 0.589, "--period-sd", 0.002)
    assert found["yaw_inertia_kgm2"] == pytest.approx(0.03886, rel=1e-3)
    assert found["sd"] == pytest.approx(2 * 0.002 / 0.589 * 0.03885, rel=0.01)


def test_inertia_finds_the_period_in_a_gyro_log():
    t = np.arange(0, 12, 0.01)
    rate = np.where(t > 1, np.exp(-0.05 * t) * np.sin(2 * np.pi * (t - 1) / 0.589), 0)
    log = table(time_s=t, yaw_rate_radps=0.2 * rate + 0.002)  # by 1°: as good as nil
    found = answer("inertia", *RIG, "--log", "-", stdin=log)
    assert found["period_s"] == pytest.approx(0.589, rel=1e-3)
    assert found["yaw_inertia_kgm2"] == pytest.approx(0.03886, rel=3e-3)


def steps():
    """A free shaft, J dω/dt = τ - B ω - T_C, in its closed form."""
    B, T_C, J = 1.2e-5, 2e-3, 2.4e-6
    t = np.arange(0, 12, 0.005)
    tau = np.select([t < 1, t < 4, t < 7, t < 10], [0, 0.006, 0.009, 0.0075], 0.0)
    omega = np.zeros_like(t)
    for k in range(1, len(t)):
        if tau[k] == 0:
            continue
        end = (tau[k] - T_C) / B
        omega[k] = end + (omega[k - 1] - end) * np.exp(-B / J * 0.005)
    noise = np.random.default_rng(1).normal(0, 0.3, len(t))
    keep = t < 10
    return t[keep], (omega + noise * (omega > 0))[keep], tau[keep], (B, T_C, J)


def test_step_fits_a_log_of_torque_and_speed():
    t, omega, tau, (B, T_C, J) = steps()
    log = table(time_s=t, motor_speed_radps=omega, motor_torque_nm=tau)
    found = answer("step", "-", stdin=log)
    assert found["damping_nms_per_rad"] == pytest.approx(B, rel=0.03)
    assert found["friction_torque_nm"] == pytest.approx(T_C, rel=0.03)
    assert found["inertia_kgm2"] == pytest.approx(J, rel=0.05)


def test_step_turns_current_into_torque_by_the_car_s_constant():
    t, omega, tau, (B, *_) = steps()
    current = tau / (1.5 * 2 * 0.887e-3)
    log = table(time_s=t, motor_speed_radps=omega, motor_current_a=current)
    found = answer("step", "-", "--vehicle", "rcc", stdin=log)
    assert found["damping_nms_per_rad"] == pytest.approx(B, rel=0.03)
    refused = rccsim("step", "-", stdin=log)
    assert refused.returncode == 2
    assert "--vehicle" in refused.stderr


def test_step_without_torque_gives_the_time_constant_alone():
    t = np.arange(0, 4, 0.005)
    omega = np.where(t > 1, 500 * (1 - np.exp(-(t - 1) / 0.2)), 0)
    log = table(time_s=t, motor_speed_radps=omega)
    found = answer("step", "-", "--open-loop", stdin=log)
    assert found["time_constant_s"] == pytest.approx(0.2, rel=0.02)
    assert found["inertia_over_damping_s"] == pytest.approx(0.2, rel=0.02)


def test_a_closed_loop_step_gives_no_inertia():
    figures = ("--speed", 527, "--torque", 0.0067, "--time-constant", 0.196)
    assert answer("step", *figures)["inertia_kgm2"] == pytest.approx(2.492e-6, rel=1e-3)
    found = answer("step", *figures, "--closed-loop")
    assert found["inertia_kgm2"] is None
    assert found["damping_nms_per_rad"] == pytest.approx(1.2713e-5, rel=1e-3)


def test_coastdown_of_a_simulated_car_gives_back_what_it_was_made_of(tmp_path):
    cycle = "time_s,speed_mps\n0,0\n3,8\n6,8\n6.5,0\n40,0\n"
    out = tmp_path / "t.csv"
    made = rccsim("simulate", "rcc", "--cycle", "-", "-o", out, stdin=cycle)
    assert made.returncode == 0, made.stderr
    found = answer("coastdown", out, "--vehicle", "rcc")
    assert found["b_n_s_per_m"] == pytest.approx(
        1.17e-5 * (11.82 / 0.049) ** 2, rel=1e-3
    )
    assert found["a_n"] == 0 and found["c_n_s2_per_m2"] == 0


def test_cg_from_scales_and_the_ballast_that_moves_it():
    found = answer(
        "cg", "--wheelbase", 0.324, "--front", 2, "--rear", 1.6, "--target", 0.16,
        "--ballast-mass", 0.4,
    )  # fmt: skip
    assert found["cg_to_front_axle_m"] == pytest.approx(0.324 * 1.6 / 3.6)
    moved = (3.6 * found["cg_to_front_axle_m"] + 0.4 * found["ballast_position_m"]) / 4
    assert moved == pytest.approx(0.16)


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (("inertia", *RIG), "--period"),
        (("inertia", *RIG, "--period", 0.5, "--log", "x.csv"), "one of them"),
        (("inertia", *RIG, "--period", "nan"), "period"),
        (("inertia", "--mass", -3, *RIG[2:], "--period", 0.5), "mass"),
        (("inertia", *RIG[:3], 535, *RIG[4:], "--period", 0.5), "metres"),
        (("inertia", *RIG, "--period", 58.9), "--cycles"),
        (("inertia", *RIG, "--log", "no.csv"), "no.csv"),
        (("step",), "--speed"),
        (("step", "--speed", 0, "--torque", 1, "--time-constant", 1), "speed"),
        (("step", "no.csv"), "no.csv"),
        (("coastdown", "no.csv", "--mass", 3), "no.csv"),
        (("cg", "--wheelbase", 324, "--front", 1, "--rear", 1), "metres"),
        (("cg", "--wheelbase", 0.3), "--balance"),
        (("cg", "--wheelbase", 0.3, "--balance", 0.15, "--target", 0.1), "--mass"),
    ],
)
def test_a_mistake_is_one_line_with_its_mend(words, found):
    done = rccsim(*words)
    assert done.returncode == 2
    assert found in done.stderr
    assert done.stderr.count("error: ") == 1
    assert "Traceback" not in done.stderr and not done.stdout


def test_a_coastdown_without_a_coast_says_what_was_found():
    log = table(time_s=np.arange(0, 5, 0.1), speed_mps=np.full(50, 3.0))
    done = rccsim("coastdown", "-", "--mass", 3, stdin=log)
    assert done.returncode == 2
    assert "no coast" in done.stderr
