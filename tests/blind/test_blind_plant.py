"""The plant behind blind cases: independent of the model, and right by itself."""

from __future__ import annotations

import ast
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rcc_sim.blind import bases, case, drives, nominal, worth
from rcc_sim.blind.plant import CLOCK, GRAVITY, SINKS, Drive, Truth

ROOT = Path(__file__).resolve().parents[2]
BLIND = ROOT / "rcc_sim" / "blind"
MODEL = ("rcc_sim.physics", "rcc_sim.simulate")
CARS = {base.name: base for base in bases.BASES}


def imports(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("path", sorted(BLIND.glob("*.py")), ids=lambda p: p.stem)
def test_no_file_of_the_blind_package_imports_the_model(path):
    assert not [name for name in imports(path) if name.startswith(MODEL)]


def test_making_a_case_loads_nothing_of_the_model():
    code = (
        "import sys, numpy\n"
        "from rcc_sim.blind.case import make_case\n"
        "make_case('c', 'single', numpy.random.default_rng(3), ['rc'])\n"
        f"assert not [m for m in sys.modules if m.startswith({MODEL!r})]\n"
        "assert 'rcc_sim.blind.plant_run' in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def programme(ref, steer=None, rows_every=0.01, dt=2.5e-4):
    """Return a drive on a smooth and level road."""
    n = len(ref)
    per = round(rows_every / dt)
    rows = np.arange(per, round((n - 1) * CLOCK / dt), per, dtype=np.int64)
    none, nil = np.zeros(n), np.zeros(1)
    steer = none if steer is None else steer
    return Drive(ref, steer, none, np.zeros(2), 5.0, nil, nil, rows)


def clock(seconds):
    return np.arange(round(seconds / CLOCK) + 1) * CLOCK


def some_drive(car, seed=1):
    road = drives.Road(np.zeros(2), np.zeros(1), np.zeros(1), 0.03, 0.5)
    rng = np.random.default_rng(seed)
    return drives.drive(car, road, next(iter(drives.STYLES[car.family])), rng)[0]


def everything(p: Truth) -> Truth:
    """Return the truth with every loss on."""
    c = p.m * GRAVITY / p.n
    return p._replace(
        dry=0.01 * c, hysteresis=0.003 * c, eddy=0.4 * p.visc, eta_gear=0.93,
        eta_motor=0.92, P_aux=0.5 * p.u_0, R_i=0.02, C_rr=0.01,
        half_rho_A=0.02 * p.m**0.5, wind=1.0, slope=0.004, mu=0.9, sigma=0.2,
        steer_lag=0.05, play=0.005,
        band_v=3.0, band_w=0.5, band_T=0.01 * c, stick_T=0.01 * c, stick_s=2.0,
    )  # fmt: skip


@pytest.mark.parametrize("name", CARS)
@pytest.mark.parametrize("change", [lambda p: p, everything], ids=["bare", "all"])
def test_the_plant_loses_no_energy_that_has_no_name(name, change):
    car = CARS[name]
    p = change(bases.truth(car, car.r_w))
    _, books = worth.fine(p, some_drive(car), car.family)
    spent = sum(books[sink] for sink in SINKS if sink != "battery")
    throughput = sum(abs(books[sink]) for sink in SINKS)
    assert throughput > 0
    assert abs(books["battery"] - spent) < 1e-5 * throughput


def test_a_wind_by_the_clock_blows_as_the_steady_one():
    car = CARS["slash"]
    p, d = bases.truth(car, car.r_w)._replace(half_rho_A=0.05), some_drive(car)
    steady, books = worth.fine(p._replace(wind=3.0), d, car.family)
    rows, also = worth.fine(p, d._replace(wind=np.full(80, 3.0)), car.family)
    assert np.array_equal(rows, steady) and also == books
    calm, _ = worth.fine(p, d, car.family)
    assert rows[:, 6].mean() > 1.05 * calm[:, 6].mean()


@pytest.mark.parametrize("name", CARS)
def test_battery_energy_is_voltage_times_current_of_the_rows(name):
    car = CARS[name]
    p = bases.truth(car, car.r_w)._replace(R_i=0.05, P_aux=2.0)
    d = some_drive(car)
    how = drives.TIMING[car.family]
    dt = how.tick / how.substeps
    per = round(CLOCK / dt)
    d = d._replace(rows=np.arange(per, round(how.seconds / dt), per, dtype=np.int64))
    rows, books = worth.fine(p, d, car.family)
    by_rows = float(np.sum(rows[:, 5] * rows[:, 6]) * CLOCK)
    # means of u and i over 10 ms, not of their product
    assert by_rows == pytest.approx(books["battery"] - books["sag"], rel=2e-3)


def test_a_coast_follows_its_closed_form():
    """M dv/dt = -(A + C v²): v = √(A/C) tan(atan(v₀ √(C/A)) - √(A C) t / M)."""
    car = CARS["slash"]
    p = bases.truth(car, car.r_w)._replace(
        visc=0.0, C_rr=0.02, half_rho_A=0.05, dead_zone=0.0
    )
    t = clock(30.0)
    ref = np.where(t < 8.0, np.clip(t, 0.0, 4.0), 0.0)
    rows, _ = worth.simulated(p, programme(ref), 1e-3, 4)
    time = 0.01 * np.arange(1, len(rows) + 1)
    k = int(np.searchsorted(time, 8.2))  # the current has died away
    A, C = p.C_rr * p.m * GRAVITY, p.half_rho_A
    M = p.m + p.J * p.n**2
    v_0, since = rows[k, 0], time[k:] - time[k]
    angle = np.arctan(v_0 * np.sqrt(C / A)) - np.sqrt(A * C) * since / M
    v = np.sqrt(A / C) * np.tan(np.maximum(angle, 0.0))
    assert v_0 > 3.5 and v[-1] == 0.0
    assert rows[k:, 0] == pytest.approx(v, abs=2e-5)


@pytest.mark.parametrize("v, delta", [(2.0, 0.05), (4.0, 0.02), (4.0, -0.05)])
@pytest.mark.parametrize("scale", [0.7, 1.0, 1.4])
def test_steady_cornering_follows_the_understeer_gradient(v, delta, scale):
    """r = v δ / (l + K v²), K = m/l (l_R/(2 C_F) - l_F/(2 C_R)); Gillespie, 1992."""
    car = replace(CARS["slash"], C_F=90.0 * scale)
    p = bases.truth(car, car.r_w)._replace(v_low=1e-3)
    t = clock(20.0)
    steer = np.where(t > 10.0, delta, 0.0)
    rows, _ = worth.simulated(p, programme(np.minimum(t, v), steer), 1e-3, 4)
    v_end = rows[-1, 0]
    wheelbase = p.l_F + p.l_R
    K = p.m / wheelbase * (p.l_R / (2 * p.C_F) - p.l_F / (2 * p.C_R))
    expected = v_end * delta / (wheelbase + K * v_end**2)
    assert rows[-1, 1] == pytest.approx(expected, rel=5e-3)  # small angles
    assert rows[-1, 3] == pytest.approx(v_end * rows[-1, 1], rel=5e-3)


def test_halving_the_step_quarters_the_error():
    car = CARS["slash"]
    p = bases.truth(car, car.r_w)._replace(v_low=0.05)
    t = clock(20.0)
    ref, steer = np.clip(t, 0.0, 3.0), 0.05 * np.sin(t) * (t > 4)
    ends = []
    for subs in (2, 4, 8):
        d = programme(ref, steer, 0.1, 1e-3 / subs)
        ends.append(worth.simulated(p, d, 1e-3, subs)[0][100:, 1])
    first, second = np.abs(ends[0] - ends[1]).max(), np.abs(ends[1] - ends[2]).max()
    assert 3.0 < first / second < 5.0


def test_tyres_that_saturate_hold_no_more_than_their_grip():
    car = CARS["racer"]
    p = bases.truth(car, car.r_w)._replace(mu=0.3)
    t = clock(30.0)
    steer = np.where(t > 6, 0.25, 0.0)
    rows, _ = worth.simulated(p, programme(np.clip(t, 0, 4.0), steer), 1e-3, 4)
    assert 0.2 * GRAVITY < np.abs(rows[:, 3]).max() < 0.3 * GRAVITY * 1.001


@pytest.mark.parametrize("name", ["slash", "racer"])
def test_plant_and_model_agree_where_nothing_is_withheld(name, tmp_path):
    from rcc_sim.blind.sensors import SENSORS
    from rcc_sim.definitions.cycle import Cycle
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.simulate.run import simulate

    car = CARS[name]
    d = drives.smooth(some_drive(car))
    rows, _ = worth.fine(bases.truth(car, car.r_w), d, "rc")
    file = tmp_path / "car.toml"
    file.write_text(nominal.vehicle_text("car", car, ()), encoding="utf-8")
    t = CLOCK * np.arange(len(d.ref))
    trace = simulate(
        load_vehicle(file),
        Cycle("drive", t, d.ref),
        steer=(t, d.steer),
        output_rate=1000,
    ).trace
    time = d.rows * 2.5e-4
    for column in ("speed_mps", "yaw_rate_radps", "battery_current_a"):
        sensor = SENSORS["rc"][column]
        model = np.interp(time, trace["time_s"], trace[column])
        apart = np.sqrt(np.mean((rows[:, sensor.place] - model) ** 2))
        assert apart < 0.5 * sensor.noise, column


# all that a file may keep but play, which remembers peaks that fall between rows
SLASH_KEEPS = {
    "drivetrain_friction.torque_nm": 0.004,
    "iron_loss.hysteresis_torque_nm": 0.002,
    "iron_loss.eddy_nms_per_rad": 5e-6,
    "gear_loss.efficiency": 0.95,
    "actuation_delay.delay_s": 0.01,
    "reference_delay.delay_s": 0.02,
    "current_limit.max_current_a": 40.0,
    "steering_offset.angle_rad": 0.01,
    "steering_gain.gain": 0.9,
    "steering_lag.time_constant_s": 0.06,
    "steering_delay.delay_s": 0.03,
    "tyre_relaxation.length_m": 0.1,
    "tyre_saturation.friction_coefficient": 0.8,
}
HATCH_KEEPS = {"friction_brake.share": 0.2, "regeneration_fade.fade_speed_mps": 3.0}
CARS_AND_MORE = {
    **CARS,
    "slash that keeps": replace(CARS["slash"], keeps=tuple(SLASH_KEEPS.items())),
    "hatch that keeps": replace(CARS["hatch"], keeps=tuple(HATCH_KEEPS.items())),
}


@pytest.mark.parametrize("name", CARS_AND_MORE)
def test_the_model_replays_a_clean_log_of_the_plant(name, tmp_path):
    """Rows lag the clock; what is left is far below the noise of the sensors."""
    from rcc_sim.blind.plant import CURRENT_LAG
    from rcc_sim.blind.sensors import SENSORS
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.simulate.drive import drive_of
    from rcc_sim.simulate.replay import replay
    from rcc_sim.trace import Trace

    car = CARS_AND_MORE[name]
    d = drives.smooth(some_drive(car))
    how = drives.TIMING[car.family]
    dt = how.tick / how.substeps
    d = d._replace(rows=np.arange(d.rows[0], d.rows[-1], round(CLOCK / dt)))
    rows, _ = worth.fine(bases.truth(car, car.r_w), d, car.family)
    places = {k: s.place for k, s in SENSORS[car.family].items()}
    log = Trace(
        case.logged_columns(
            car.family, d.rows * dt, {k: rows[:, i] for k, i in places.items()},
            np.ones(len(rows), dtype=bool), d, surveyed=False,
        )
    )  # fmt: skip
    file = tmp_path / "car.toml"
    file.write_text(nominal.vehicle_text("car", car, ()), encoding="utf-8")
    vehicle = load_vehicle(file)
    if car.family == "rc":
        lag = {"effects.motor_lag.time_constant_s": CURRENT_LAG}
        vehicle = vehicle.changed(settings=lag)
    model = replay(vehicle, drive_of(log, vehicle))
    rolling = log["speed_mps"] > 0.2 * car.v_max
    for column in places.keys() - {"elevation_m"}:
        apart = (log[column] - model[column])[rolling]
        noise = SENSORS[car.family][column].noise
        assert np.sqrt(np.mean(apart**2)) < 0.05 * noise, column
