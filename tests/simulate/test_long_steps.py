"""A drive whose motion was logged ten times a second, beside an integrator's answer."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from tests.cars import truck

SPEED = 14.0  # m/s
TIME = np.arange(0.0, 30.0, 0.1)
STEER = 0.01 * np.sin(1.9 * TIME) + 0.004 * np.sin(0.7 * TIME)
LAG, DELAY, LENGTH = 0.15, 0.13, 0.9


def logged():
    """A steady speed, steered from side to side."""
    speed = np.full(len(TIME), SPEED)
    return Trace({"time_s": TIME, "speed_mps": speed, "steer_cmd_rad": STEER}, name="x")


def yaw_rate(vehicle, lag=0.0, delay=0.0, length=0.0):
    """Yaw rate of the linear bicycle at a steady speed, by an adaptive integrator."""
    body, tyres = vehicle.body, vehicle.tyres
    m, I_z = body.mass_kg.value, body.yaw_inertia_kgm2.value
    l_F, l_R = body.cg_to_front_axle_m.value, body.cg_to_rear_axle_m.value
    C_F = 2 * tyres.front_cornering_stiffness_n_per_rad.value
    C_R = 2 * tyres.rear_cornering_stiffness_n_per_rad.value

    def change(t, state):
        v_y, r, angle, held_F, held_R = state
        asked = np.interp(t - delay, TIME, STEER)
        angle = angle if lag else asked
        slip_F, slip_R = (v_y + l_F * r) / SPEED - angle, (v_y - l_R * r) / SPEED
        F_F, F_R = (
            (-C_F * held_F, -C_R * held_R) if length else (-C_F * slip_F, -C_R * slip_R)
        )
        return (
            (F_F + F_R) / m - SPEED * r,
            (l_F * F_F - l_R * F_R) / I_z,
            (asked - angle) / lag if lag else 0.0,
            SPEED * (slip_F - held_F) / length if length else 0.0,
            SPEED * (slip_R - held_R) / length if length else 0.0,
        )

    span = (TIME[0], TIME[-1])
    done = solve_ivp(
        change, span, np.zeros(5), t_eval=TIME, rtol=1e-9, atol=1e-12, max_step=0.02
    )
    return done.y[1]


@pytest.mark.parametrize(
    ("effect", "given"),
    [
        ({}, {}),
        ({"steering_lag": {"time_constant_s": LAG}}, {"lag": LAG}),
        ({"steering_delay": {"delay_s": DELAY}}, {"delay": DELAY}),
        ({"tyre_relaxation": {"length_m": LENGTH}}, {"length": LENGTH}),
    ],
)
@pytest.mark.parametrize(("coarse", "most"), [(False, 2e-4), (True, 2e-3)])
def test_steps_as_long_as_they_may_be_turn_as_an_integrator_does(
    effect, given, coarse, most
):
    vehicle = truck(effect)
    out = replay(vehicle, drive_of(logged(), vehicle), coarse=coarse)
    known = yaw_rate(vehicle, **given)
    off = out["yaw_rate_radps"] - known
    assert np.sqrt(np.mean(off[20:] ** 2)) < most * known.std()


@pytest.mark.parametrize("known", ["yaw_rate_radps", "steer_cmd_rad"])
def test_half_a_step_errs_by_a_quarter_in_hard_bends_too(known):
    """A town drive at 1 Hz, bends and a hill: the energy, and each row's power."""
    town = parse_cycle("udds[0:500]")
    turns = np.sin(0.05 * town.time_s)
    size = {"yaw_rate_radps": 0.02 * town.speed_mps, "steer_cmd_rad": 0.07}
    columns = {
        "time_s": town.time_s,
        "speed_mps": town.speed_mps,
        known: size[known] * turns,
        "slope": 0.04 * np.sin(0.02 * town.time_s),
    }
    vehicle = truck({"aerodynamic_drag": {"drag_area_m2": 1.0}})
    drive = drive_of(Trace(columns, name="x"), vehicle, window=np.inf)
    assert drive.imposed and drive.steered == (known == "steer_cmd_rad")
    one, half, fine = (
        replay(vehicle, drive, substeps=k)["battery_power_w"][1:] for k in (1, 2, 40)
    )
    assert one.sum() == pytest.approx(fine.sum(), rel=1e-4)
    assert np.abs(one - fine).max() < 1e-4 * np.abs(fine).max()
    assert np.abs(half - fine).max() < 0.3 * np.abs(one - fine).max()


def test_bends_that_a_gyro_shows_take_what_they_do_by_their_steering():
    """Swerves: were sideslip settled at once, they would seem to take more."""
    vehicle = truck({})
    swerve = 0.02 * np.sin(4.0 * TIME)
    work = []
    log = Trace(
        {
            "time_s": TIME,
            "speed_mps": np.full(len(TIME), SPEED),
            "steer_cmd_rad": swerve,
        }
    )
    steered = replay(vehicle, drive_of(log, vehicle, window=np.inf))
    for turns in (steered["yaw_rate_radps"], 0.0 * swerve):
        columns = dict(log.columns) | {"yaw_rate_radps": turns}
        del columns["steer_cmd_rad"]
        drive = drive_of(Trace(columns, name="x"), vehicle, window=np.inf)
        assert drive.turns_as_measured
        work.append(replay(vehicle, drive))
    turned, straight = (one["battery_power_w"][1:].sum() for one in work)
    taken = steered["battery_power_w"][1:].sum() - straight
    assert turned - straight == pytest.approx(taken, rel=0.05)
    felt = work[0]["accel_y_mps2"] - steered["accel_y_mps2"]
    assert np.std(felt[20:]) < 0.05 * np.std(steered["accel_y_mps2"])


def test_means_before_a_row_are_over_their_own_time_however_long_the_steps():
    """A speed that bends between the rows: what it gains in the last 10 ms of each."""
    speed = 10 + 3 * np.sin(0.9 * TIME)
    log = Trace({"time_s": TIME, "speed_mps": speed}, name="x")
    drive = drive_of(log, truck())
    long, short = (
        replay(truck(), drive, coarse=c, substeps=k)
        for c, k in ((True, 1), (False, 20))
    )
    for column in ("accel_x_mps2", "battery_power_w", "motor_torque_nm"):
        off = (long[column] - short[column])[1:]
        assert np.abs(off).max() < 2e-3 * np.abs(short[column]).max()
