"""What may act and is in no library: a patch, a rub, a sticking brake, and others."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rcc_sim.blind.drives import TIMING
from rcc_sim.blind.plant import GRAVITY
from rcc_sim.blind.strengths import Scene, Withheld

Draw = Callable[[Scene, np.random.Generator], Withheld]


def _drag(scene: Scene, share: float) -> float:
    """Shaft torque [N m] of a force that is a share of the weight."""
    return share * scene.p.m * GRAVITY / scene.p.n


def _made(name: str, on: dict[str, float], off: dict[str, float]) -> Withheld:
    return Withheld(name, dict(on), on, off)


def slippery_patch(scene: Scene, rng: np.random.Generator) -> Withheld:
    """Short stretches of road on which the tyres hold little."""
    rc = scene.car.family == "rc"
    every = float(rng.uniform(30, 60) if rc else rng.uniform(700, 1500))
    on = {
        "patch_mu": float(rng.uniform(0.12, 0.3) if rc else rng.uniform(0.06, 0.15)),
        "patch_every": every,
        "patch_from": float(rng.uniform(0.2, 0.8)) * every,
        "patch_long": float(rng.uniform(0.12, 0.3)) * every,
    }
    return _made("slippery_patch", on, {"patch_mu": np.inf})


def one_sided_steering(scene: Scene, rng: np.random.Generator) -> Withheld:
    """Steering that gives less (or more) to the left than to the right."""
    x = 1.0 + float(rng.choice([-1, 1]) * rng.uniform(0.15, 0.35))
    return _made("one_sided_steering", {"left_gain": x}, {"left_gain": 1.0})


def tyre_rub(scene: Scene, rng: np.random.Generator) -> Withheld:
    """A tyre that rubs on its arch beyond some steering angle."""
    rc = scene.car.family == "rc"
    on = {
        "rub_at": float(rng.uniform(0.03, 0.08) if rc else rng.uniform(0.008, 0.02)),
        "rub_T": _drag(scene, float(rng.uniform(0.04, 0.1))),
    }
    return _made("tyre_rub", on, {"rub_T": 0.0})


def resonance_band(scene: Scene, rng: np.random.Generator) -> Withheld:
    """Drag in a narrow band of speeds."""
    on = {
        "band_v": float(rng.uniform(0.4, 0.75)) * scene.car.v_max,
        "band_w": float(rng.uniform(0.03, 0.08)) * scene.car.v_max,
        "band_T": _drag(scene, float(rng.uniform(0.02, 0.06))),
    }
    return _made("resonance_band", on, {"band_T": 0.0})


def sticking_brake(scene: Scene, rng: np.random.Generator) -> Withheld:
    """Drag that stays for a while after each slowing down."""
    rc = scene.car.family == "rc"
    on = {
        "stick_T": _drag(scene, float(rng.uniform(0.015, 0.04))),
        "stick_s": float(rng.uniform(2, 6) if rc else rng.uniform(8, 25)),
    }
    return _made("sticking_brake", on, {"stick_T": 0.0})


def warm_up_drag(scene: Scene, rng: np.random.Generator) -> Withheld:
    """Drag that dies away as the gears grow warm."""
    rc = scene.car.family == "rc"
    on = {
        "warm_T": _drag(scene, float(rng.uniform(0.015, 0.04))),
        "warm_s": float(rng.uniform(10, 25) if rc else rng.uniform(80, 200)),
    }
    return _made("warm_up_drag", on, {"warm_T": 0.0})


def freezing_steering(scene: Scene, rng: np.random.Generator) -> Withheld:
    """A servo that stands still for a moment, again and again."""
    rc = scene.car.family == "rc"
    on = {
        "freeze_every": float(rng.uniform(7, 15) if rc else rng.uniform(40, 90)),
        "freeze_s": float(rng.uniform(0.8, 2.0) if rc else rng.uniform(4, 10)),
    }
    return _made("freezing_steering", on, {"freeze_s": 0.0, "freeze_every": np.inf})


def lost_load(scene: Scene, rng: np.random.Generator) -> Withheld:
    """A load, in the file, that falls off on the way."""
    lasts = TIMING[scene.car.family].seconds
    on = {
        "drop_m": float(rng.uniform(0.12, 0.3)) * scene.p.m,
        "drop_t": float(rng.uniform(0.3, 0.6)) * lasts,
    }
    return _made("lost_load", on, {"drop_m": 0.0, "drop_t": np.inf})


def overloaded_inverter(scene: Scene, rng: np.random.Generator) -> Withheld:
    """An inverter that loses more the harder the motor is driven."""
    most = scene.p.K_t * scene.most_current
    on = {
        "over_T": float(rng.uniform(0.15, 0.35)) * most,
        "over_loss": float(rng.uniform(0.05, 0.15)),
    }
    return _made("overloaded_inverter", on, {"over_loss": 0.0})


UNKNOWNS: dict[str, Draw] = {
    draw.__name__: draw
    for draw in (
        slippery_patch,
        one_sided_steering,
        tyre_rub,
        resonance_band,
        sticking_brake,
        warm_up_drag,
        freezing_steering,
        lost_load,
        overloaded_inverter,
    )
}
