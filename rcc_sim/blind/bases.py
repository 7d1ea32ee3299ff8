"""Vehicles to draw around, and what a stated figure may be wrong by."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import inf
from typing import Any

import numpy as np

from rcc_sim.blind.plant import Truth

SPREAD = 0.3  # 1; the most by which a figure of a base is moved
AIR = 1.2  # kg/m³
STABLE = 0.55  # 1; least (l + K v²) / l at the top speed: no car that spins by itself


@dataclass(frozen=True)
class Base:
    """A vehicle to draw around. SI, per tyre, shaft figures at the motor.

    One whose motor is not known has no poles and no flux; what it loses is ``loss``, a
    share of the power. Battery resistances are drawn in times ``sag``. What the car
    ``keeps`` acts as its file states it, in every drive: figures of ``KEPT``, by key.
    """

    name: str
    family: str  # rc or ev
    m: float
    I_z: float
    l_F: float
    l_R: float
    C_F: float
    C_R: float
    r_w: float
    N_d: float
    poles: int
    flux: float
    u_0: float
    capacity: float
    v_max: float  # of its drives
    visc: float = 0.0
    J: float = 0.0
    R_phase: float = 0.0
    C_rr: float = 0.0
    drag_area: float = 0.0
    P_aux: float = 0.0
    K_p: float = 0.0
    K_i: float = 0.0
    i_max: float = inf
    tau_max: float = inf
    dead_zone: float = 0.0
    regen: float = inf
    loss: float = 0.0
    R_i: float = 0.0
    sag: float = 1.0
    keeps: tuple[tuple[str, float], ...] = ()


BASES = (
    Base(
        "slash", "rc", 3.78, 0.0382, 0.15876, 0.16523, 90.0, 90.0, 0.049, 11.82, 4,
        0.887e-3, 12.0, 5.2, 5.3, visc=1.17e-5, J=2.2e-6, R_phase=0.030, K_p=0.32,
        K_i=0.6, i_max=50.0, dead_zone=41.9, regen=0.0,
    ),  # the car of Kumari et al.; resistance with cables and ESC, gains as VESC's
    Base(
        "racer", "rc", 3.47, 0.0455, 0.15875, 0.17145, 70.0, 75.0, 0.0508, 11.0, 4,
        0.95e-3, 11.5, 5.0, 5.6, visc=1.4e-5, J=2.8e-6, R_phase=0.025, K_p=0.28,
        K_i=0.5, i_max=60.0, dead_zone=50.0, regen=0.0,
    ),  # like an F1TENTH car: mass and axles as published, the rest a guess
    Base(
        "pickup", "ev", 3152.0, 5000.0, 1.6915, 1.7605, 40700.0, 45000.0, 0.4191, 12.0,
        8, 0.1, 400.0, 330.0, 27.0, visc=0.1, J=0.2, R_phase=0.0225, C_rr=0.010,
        drag_area=0.95, P_aux=600.0, tau_max=1231.0, regen=900.0,
    ),  # the R1T of Kumari et al.; rolling, air and auxiliaries a guess
    Base(
        "sedan", "ev", 1850.0, 2900.0, 1.45, 1.43, 55000.0, 62000.0, 0.34, 9.03, 6,
        0.075, 360.0, 215.0, 30.0, visc=0.025, J=0.06, R_phase=0.011, C_rr=0.009,
        drag_area=0.55, P_aux=400.0, tau_max=420.0, regen=250.0,
    ),  # like a mid-size electric sedan: a guess
    Base(
        "hatch", "ev", 1330.0, 1750.0, 1.31, 1.26, 38000.0, 46000.0, 0.35, 9.7, 12,
        0.035, 355.0, 60.0, 25.0, visc=0.02, J=0.05, R_phase=0.012, C_rr=0.0085,
        drag_area=0.68, P_aux=350.0, tau_max=250.0, regen=180.0,
    ),  # like a small electric hatchback: a guess
)  # fmt: skip

WEIGHTS = {"slash": 0.75, "racer": 0.25, "pickup": 0.5, "sedan": 0.25, "hatch": 0.25}

TOLERANCES = {
    "m": 0.005,
    "I_z": 0.03,
    "l_F": 0.005,
    "l_R": 0.005,
    "r_w": 0.004,
    "C_F": 0.04,
    "C_R": 0.04,
    "flux": 0.01,
    "visc": 0.05,
    "J": 0.06,
    "R_phase": 0.05,
    "C_rr": 0.05,
    "drag_area": 0.04,
    "P_aux": 0.10,
    "loss": 0.10,
    "R_i": 0.10,
}
"""One standard deviation of a stated figure, as a share of it."""

RARE = ("loss", "R_i")
"""Of a user's own vehicle alone."""

EXACT = (
    *("name", "family", "poles", "N_d", "u_0", "capacity", "v_max", "i_max", "regen"),
    *("loss", "R_i", "sag", "keeps"),
)

KEPT = {
    "drivetrain_friction.torque_nm": "dry",
    "iron_loss.hysteresis_torque_nm": "hysteresis",
    "iron_loss.eddy_nms_per_rad": "eddy",
    "gear_loss.efficiency": "eta_gear",
    "motor_lag.time_constant_s": "lag",
    "actuation_delay.delay_s": "delay",
    "reference_delay.delay_s": "ref_delay",
    "current_limit.max_current_a": "i_limit",
    "friction_brake.share": "brake_share",
    "regeneration_fade.fade_speed_mps": "fade",
    "steering_offset.angle_rad": "steer_offset",
    "steering_gain.gain": "steer_gain",
    "steering_lag.time_constant_s": "steer_lag",
    "steering_delay.delay_s": "steer_delay",
    "steering_backlash.width_rad": "play",
    "tyre_relaxation.length_m": "sigma",
    "tyre_saturation.friction_coefficient": "mu",
}
"""What a user's file may state besides, by the plant's own names."""


def moved(base: Base, rng: np.random.Generator) -> Base:
    """Return the base with each figure moved by up to 30 %, and stable at speed."""
    while True:
        change = {
            f.name: getattr(base, f.name) * (1 + SPREAD * rng.uniform(-1, 1))
            for f in fields(base)
            if f.name not in EXACT and f.name not in ("r_w", "flux", "tau_max")
        }
        for name in ("r_w", "flux"):  # a third of it: gears and voltage go with them
            change[name] = getattr(base, name) * (1 + SPREAD / 3 * rng.uniform(-1, 1))
        car = replace(base, **change)
        if 0.8 < car.l_F / car.l_R < 1.25 and margin(car) > STABLE:
            return car


def margin(car: Base) -> float:
    """Return (l + K v²) / l at top speed: 0 is where a car turns unstable. [1]

    K is the understeer gradient m/l (l_R/(2 C_F) - l_F/(2 C_R)); Gillespie, 1992.
    """
    wheelbase = car.l_F + car.l_R
    K = car.m / wheelbase * (car.l_R / (2 * car.C_F) - car.l_F / (2 * car.C_R))
    return 1 + K * car.v_max**2 / wheelbase


def stated(
    car: Base, rng: np.random.Generator
) -> tuple[Base, dict[str, float], dict[str, float]]:
    """Return the figures as a file states them, their sds, and how many sds off.

    The file's figure is the true one times 1 + sd · N(0, 1).
    """
    off = {n: sd for n, sd in TOLERANCES.items() if n not in RARE or getattr(car, n)}
    pulls = {name: float(rng.standard_normal()) for name in off}
    values = {
        name: getattr(car, name) * (1 + sd * pulls[name]) for name, sd in off.items()
    }
    file = replace(car, **values)
    sds = {name: sd * getattr(file, name) for name, sd in off.items()}
    return file, sds, pulls


def truth(car: Base, r_file: float) -> Truth:
    """Return the plant's figures of a car whose log and controller use r_file [m]."""
    plain = Truth(
        speed_mode=car.family == "rc",
        m=car.m,
        I_z=car.I_z,
        l_F=car.l_F,
        l_R=car.l_R,
        C_F=car.C_F,
        C_R=car.C_R,
        n=car.N_d / car.r_w,
        n_file=car.N_d / r_file,
        K_t=1.5 * car.poles / 2 * car.flux or 1.0,
        K_p=car.K_p,
        K_i=car.K_i,
        i_max=car.i_max,
        tau_max=car.tau_max,
        J=car.J,
        visc=car.visc,
        R_phase=car.R_phase,
        eta_motor=1.0 - car.loss,
        P_aux=car.P_aux,
        u_0=car.u_0,
        R_i=car.R_i,
        regen=car.regen,
        dead_zone=car.dead_zone,
        C_rr=car.C_rr,
        half_rho_A=0.5 * AIR * car.drag_area,
        v_low=0.05 if car.family == "rc" else 0.2,
    )
    kept: dict[str, Any] = {KEPT[key]: value for key, value in car.keeps}
    return plain._replace(**kept)


def shifted(p: Truth, name: str, share: float) -> Truth:
    """Return the plant with one toleranced figure greater by a share of itself."""
    if name == "r_w":
        return p._replace(n=p.n / (1 + share))
    if name == "loss":
        return p._replace(eta_motor=1 - (1 - p.eta_motor) * (1 + share))
    field_of = {"flux": "K_t", "drag_area": "half_rho_A"}
    key = field_of.get(name, name)
    return p._replace(**{key: getattr(p, key) * (1 + share)})
