"""Which effects may be withheld, and how strong each one is drawn."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.blind.bases import AIR, Base
from rcc_sim.blind.drives import TIMING, gusts, heater, hills, turned
from rcc_sim.blind.plant import GRAVITY, Truth

Array = NDArray[np.float64]
HILLS_LENGTH = 40000.0  # m; more than any drive covers


@dataclass(frozen=True)
class Scene:
    """What a strength may depend on: the car, its figures, how hard it is driven."""

    car: Base
    p: Truth
    most_current: float  # A, motoring, without the effect
    most_braking: float  # N m at the shaft


@dataclass(frozen=True)
class Withheld:
    """An effect that acts: what it changes in the truth, and what it was without it.

    ``sensor`` maps a channel to the scale and the bias that its readings take.
    """

    effect: str
    magnitudes: dict[str, float]
    on: dict[str, float] = field(default_factory=dict)
    off: dict[str, float] = field(default_factory=dict)
    sensor: dict[str, tuple[float, float]] = field(default_factory=dict)
    slope: Array | None = None
    aux: Array | None = None
    wind: Array | None = None


Draw = Callable[[Scene, np.random.Generator], Withheld]


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _scale(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a factor that departs from 1 by low to high, either way."""
    return 1.0 + _sign(rng) * float(rng.uniform(low, high))


def _hidden(effect: str, key: str, name: str) -> Draw:
    """An effect that the car has anyway, and the file does not state."""

    def draw(scene: Scene, rng: np.random.Generator) -> Withheld:
        value = getattr(scene.p, name)
        return Withheld(effect, {key: value}, {name: value}, {name: 0.0})

    return draw


def _plain(effect: str, key: str, name: str, value: Any, neutral: float) -> Draw:
    """An effect of one figure; value is drawn from the scene."""

    def draw(scene: Scene, rng: np.random.Generator) -> Withheld:
        x = float(value(scene, rng))
        return Withheld(effect, {key: x}, {name: x}, {name: neutral})

    return draw


def _scaled(effect: str, names: tuple[str, ...], low: float, high: float) -> Draw:
    """An effect that scales figures of the car."""

    def draw(scene: Scene, rng: np.random.Generator) -> Withheld:
        x = _scale(rng, low, high)
        off = {name: getattr(scene.p, name) for name in names}
        return Withheld(effect, {"scale": x}, {k: v * x for k, v in off.items()}, off)

    return draw


def _wheel(scene: Scene, rng: np.random.Generator) -> Withheld:
    x = _scale(rng, 0.025, 0.09)
    n = scene.p.n
    return Withheld("wheel_radius", {"scale": x}, {"n": n / x}, {"n": n})


def _payload(scene: Scene, rng: np.random.Generator) -> Withheld:
    p = scene.p
    share = float(rng.uniform(0.07, 0.35))
    on = {"m": p.m * (1 + share), "I_z": p.I_z * (1 + share)}
    return Withheld("payload", {"mass_kg": p.m * share}, on, {"m": p.m, "I_z": p.I_z})


def _cg(scene: Scene, rng: np.random.Generator) -> Withheld:
    p = scene.p
    x = _sign(rng) * float(rng.uniform(0.05, 0.12)) * (p.l_F + p.l_R)
    on = {"l_F": p.l_F - x, "l_R": p.l_R + x}
    return Withheld("cg_shift", {"shift_m": x}, on, {"l_F": p.l_F, "l_R": p.l_R})


def _loop(scene: Scene, rng: np.random.Generator) -> Withheld:
    p = scene.p
    x = float(np.exp(_sign(rng) * rng.uniform(0.35, 0.8)))
    off = {"K_p": p.K_p}
    return Withheld("speed_loop", {"proportional_scale": x}, {"K_p": p.K_p * x}, off)


def _grade(scene: Scene, rng: np.random.Generator) -> Withheld:
    if scene.car.family == "rc":
        x = _sign(rng) * float(rng.uniform(0.006, 0.025))
        return Withheld("road_grade", {"slope": x}, {"slope": x}, {"slope": 0.0})
    sd = float(rng.uniform(0.006, 0.02))
    slope = hills(HILLS_LENGTH, sd, rng)
    return Withheld("road_grade", {"slope_std": sd}, slope=slope)


def _auxiliary(scene: Scene, rng: np.random.Generator) -> Withheld:
    car = scene.car
    known = scene.p.P_aux
    low, high = (3.0, 18.0) if car.family == "rc" else (700.0, 4500.0)
    size = (car.m / 3.78) if car.family == "rc" else min(car.m / 3152.0 + 0.3, 1.0)
    more = float(rng.uniform(low, high)) * size
    if rng.random() < 0.35:
        seconds = TIMING[car.family].seconds
        aux = heater(seconds, more, rng)
        return Withheld("auxiliary_load", {"power_w_mean": known + aux.mean()}, aux=aux)
    total = known + more
    on, off = {"P_aux": total}, {"P_aux": known}
    return Withheld("auxiliary_load", {"power_w": total}, on, off)


def _wind(scene: Scene, rng: np.random.Generator) -> Withheld:
    """A wind that changes: in gusts, or by the road that turns, over a steady one."""
    seconds = TIMING[scene.car.family].seconds
    if rng.random() < 0.5:
        wind = gusts(seconds, rng.uniform(1.5, 4.0), rng.uniform(15.0, 80.0), rng)
        wind += _sign(rng) * rng.uniform(0.0, 6.0)
    else:
        wind = turned(seconds, rng.uniform(3.0, 8.0), rng.uniform(60.0, 250.0), rng)
    return Withheld("headwind", {"speed_mps_mean": wind.mean()}, wind=wind)


def _regeneration(scene: Scene, rng: np.random.Generator) -> Withheld:
    key, name = "regeneration_limit", "regen"
    if scene.car.family == "rc":
        return Withheld(key, {"max_current_a": 0.0}, {name: 0.0}, {name: inf})
    x = float(rng.uniform(0.0, 0.4)) * scene.most_braking
    return Withheld(key, {"max_torque_nm": x}, {name: x}, {name: inf})


def _aero(scene: Scene, rng: np.random.Generator) -> Withheld:
    A = scene.car.drag_area
    if scene.car.family == "rc":
        A = float(rng.uniform(0.03, 0.12))
    on = {"half_rho_A": 0.5 * AIR * A}
    return Withheld("aerodynamic_drag", {"drag_area_m2": A}, on, {"half_rho_A": 0.0})


def _rolling(scene: Scene, rng: np.random.Generator) -> Withheld:
    C = scene.p.C_rr or float(rng.uniform(0.007, 0.025))
    return Withheld("rolling_resistance", {"coefficient": C}, {"C_rr": C}, {"C_rr": 0})


def _sensor(effect: str, key: str, channels: tuple[str, ...], value: Any) -> Draw:
    """An effect of a sensor: a scale where the key says so, else a bias."""

    def draw(scene: Scene, rng: np.random.Generator) -> Withheld:
        x = float(value(scene, rng))
        change = (x, 0.0) if key == "scale" else (1.0, x)
        return Withheld(effect, {key: x}, sensor=dict.fromkeys(channels, change))

    return draw


def _either(rc: tuple[float, float], ev: tuple[float, float], signed: bool) -> Any:
    """Draw from a range by family, with either sign where it has one."""

    def value(scene: Scene, rng: np.random.Generator) -> float:
        x = float(rng.uniform(*(rc if scene.car.family == "rc" else ev)))
        return x * (_sign(rng) if signed else 1.0)

    return value


def _dry(scene: Scene, rng: np.random.Generator) -> float:
    C = (
        rng.uniform(0.007, 0.025)
        if scene.car.family == "rc"
        else rng.uniform(3e-3, 0.012)
    )
    return float(C) * scene.p.m * GRAVITY / scene.p.n


RESISTANCE = _either((0.02, 0.08), (0.03, 0.12), False)

BOTH: dict[str, Draw] = {
    "drivetrain_damping": _hidden("drivetrain_damping", "damping_nms_per_rad", "visc"),
    "rotor_inertia": _hidden("rotor_inertia", "inertia_kgm2", "J"),
    "copper_loss": _hidden("copper_loss", "phase_resistance_ohm", "R_phase"),
    "drivetrain_friction": _plain(
        "drivetrain_friction", "torque_nm", "dry", _dry, 0.0
    ),
    "gear_loss": _plain(
        "gear_loss", "efficiency", "eta_gear",
        lambda s, rng: rng.uniform(0.85, 0.96), 1.0,
    ),
    "iron_loss": _plain(
        "iron_loss", "eddy_nms_per_rad", "eddy",
        lambda s, rng: s.car.visc * rng.uniform(0.4, 1.0), 0.0,
    ),
    "auxiliary_load": _auxiliary,
    "battery_resistance": _plain(
        "battery_resistance", "resistance_ohm", "R_i",
        lambda s, rng: s.car.sag * RESISTANCE(s, rng), 0.0,
    ),
    "regeneration_limit": _regeneration,
    "rolling_resistance": _rolling,
    "aerodynamic_drag": _aero,
    "road_grade": _grade,
    "payload": _payload,
    "wheel_radius": _wheel,
    "steering_offset": _plain(
        "steering_offset", "angle_rad", "steer_offset",
        _either((0.01, 0.035), (0.003, 0.012), True), 0.0,
    ),
    "steering_gain": _plain(
        "steering_gain", "gain", "steer_gain",
        lambda s, rng: _scale(rng, 0.08, 0.25), 1.0,
    ),
    "steering_lag": _plain(
        "steering_lag", "time_constant_s", "steer_lag",
        _either((0.03, 0.12), (0.08, 0.4), False), 0.0,
    ),
    "steering_delay": _plain(
        "steering_delay", "delay_s", "steer_delay",
        _either((0.03, 0.12), (0.1, 0.4), False), 0.0,
    ),
    "steering_backlash": _plain(
        "steering_backlash", "width_rad", "play",
        _either((0.012, 0.035), (0.006, 0.016), False), 0.0,
    ),
    "front_cornering_stiffness": _scaled(
        "front_cornering_stiffness", ("C_F",), 0.18, 0.45
    ),
    "rear_cornering_stiffness": _scaled(
        "rear_cornering_stiffness", ("C_R",), 0.18, 0.45
    ),
    "tyre_saturation": _plain(
        "tyre_saturation", "friction_coefficient", "mu",
        _either((0.5, 0.8), (0.25, 0.45), False), inf,
    ),
    "tyre_relaxation": _plain(
        "tyre_relaxation", "length_m", "sigma",
        _either((0.08, 0.3), (0.5, 1.5), False), 0.0,
    ),
    "cg_shift": _cg,
    "yaw_inertia": _scaled("yaw_inertia", ("I_z",), 0.2, 0.5),
    "speed_sensor_scale": _sensor(
        "speed_sensor_scale", "scale", ("speed_mps",),
        lambda s, rng: _scale(rng, 0.02, 0.06),
    ),
    "current_sensor_scale": _sensor(
        "current_sensor_scale", "scale", ("battery_current_a",),
        lambda s, rng: _scale(rng, 0.03, 0.1),
    ),
    "yaw_rate_bias": _sensor(
        "yaw_rate_bias", "bias_radps", ("yaw_rate_radps",),
        _either((0.025, 0.08), (0.008, 0.03), True),
    ),
    "accelerometer_bias": _sensor(
        "accelerometer_bias", "x_mps2", ("accel_x_mps2",),
        _either((0.2, 0.5), (0.15, 0.4), True),
    ),
}  # fmt: skip

ONLY = {
    "rc": {
        "speed_dead_zone": _hidden(
            "speed_dead_zone", "threshold_radps", "dead_zone"
        ),
        "reference_sampling": _plain(
            "reference_sampling", "period_s", "hold",
            lambda s, rng: round(float(rng.uniform(0.05, 0.4)), 2), 0.01,
        ),
        "actuation_delay": _plain(
            "actuation_delay", "delay_s", "delay",
            lambda s, rng: round(float(rng.uniform(0.02, 0.08)), 3), 0.0,
        ),
        "motor_lag": _plain(
            "motor_lag", "time_constant_s", "lag",
            lambda s, rng: rng.uniform(0.03, 0.12), 0.0,
        ),
        "speed_loop": _loop,
        "current_limit": _plain(
            "current_limit", "max_current_a", "i_limit",
            lambda s, rng: s.most_current * rng.uniform(0.45, 0.8), inf,
        ),
    },
    "ev": {
        "headwind": _plain(
            "headwind", "speed_mps", "wind", _either((0, 0), (3.5, 9.0), True), 0.0
        ),
    },
}  # fmt: skip

ASKED: dict[str, dict[str, Draw]] = {
    "rc": {
        "reference_delay": _plain(
            "reference_delay", "delay_s", "ref_delay",
            lambda s, rng: round(float(rng.uniform(0.04, 0.16)), 3), 0.0,
        ),
    },
    "ev": {
        "friction_brake": _plain(
            "friction_brake", "share", "brake_share",
            lambda s, rng: rng.uniform(0.1, 0.45), 0.0,
        ),
        "regeneration_fade": _plain(
            "regeneration_fade", "fade_speed_mps", "fade",
            lambda s, rng: rng.uniform(2.0, 6.0), 0.0,
        ),
        "headwind": _wind,
    },
}  # fmt: skip
"""Effects that are drawn only where they are asked for: they are younger than the seeds
of which results are stated; a wind that is asked for is no steady one."""

TERMS = ("copper_loss", "iron_loss")
"""Losses that an efficiency as a whole stands for."""


def draws(
    family: str, lossy: bool = False, asked: Collection[str] = ()
) -> dict[str, Draw]:
    """Return the effects that may act in a family's logs, by id.

    A car of which the efficiency is known has no single losses beside it. Those of
    ``ASKED`` are among them where they are asked for.
    """
    younger = {k: v for k, v in ASKED[family].items() if k in asked}
    found = {**BOTH, **ONLY[family], **younger}
    return {k: v for k, v in found.items() if not (lossy and k in TERMS)}
