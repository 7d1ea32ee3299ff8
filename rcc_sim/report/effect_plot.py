"""What an effect does to a reference drive, drawn: off against on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.catalogue import effect_of
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.figure import Figure as Stated
from rcc_sim.definitions.vehicle import Vehicle, load_vehicle
from rcc_sim.physics.effect import Effect
from rcc_sim.report.channels import title_of
from rcc_sim.report.sheet import draw_line, head, legend_above, name_upright, sheet
from rcc_sim.simulate.given import Profile, throttle_drive
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from rcc_sim.units import unit_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BASE = {
    "rolling_resistance": {"coefficient": 0.02},
    "aerodynamic_drag": {"drag_area_m2": 0.03},
}
"""What the reference car has besides its own effects, so that each has its grip."""

PANELS = 3
"""Channels that are drawn: those that the effect moves most."""

CHANNELS = (
    "speed_mps",
    "motor_current_a",
    "battery_power_w",
    "battery_voltage_v",
    "battery_current_a",
    "accel_x_mps2",
    "yaw_rate_radps",
    "accel_y_mps2",
    "x_m",
    "y_m",
)

SMALL: dict[str, dict[str, float]] = {
    "battery_resistance": {"resistance_ohm": 0.05},
    "cg_shift": {"shift_m": 0.03},
    "drivetrain_friction": {"torque_nm": 0.002},
    "friction_brake": {"share": 0.4},
    "iron_loss": {"hysteresis_torque_nm": 0.001, "eddy_nms_per_rad": 1e-6},
    "payload": {"mass_kg": 0.5},
    "reference_sampling": {"period_s": 0.1},
    "road_load": {"a_n": 1.0, "b_n_s_per_m": 0.3, "c_n_s2_per_m2": 0.02},
    "sensor_delay": {"delay_s": 0.1},
    "steering_drag": {"force_n_per_rad": 5.0},
    "throttle_dead_zone": {"threshold": 0.25},
    "tyre_relaxation": {"length_m": 0.1},
}
"""Values that suit the reference car where the typical range is that of larger ones."""

HELD_BY = dict.fromkeys(
    ("friction_brake", "regeneration_fade"), ("regeneration_limit",)
)
"""Effect -> what keeps it from acting in the reference car: no motor brakes there."""

LOAD = [0.0, 6.0, 6.5, 18.0], [2.0, 2.0, 10.0, 10.0]
"""Time [s] and auxiliary power [W] that are logged on the reference drive."""

SEEN = 1e-3
"""Share of its own range by which a channel must move to be drawn. [1]"""


def plot_effect(name: str) -> Figure:
    """Draw a reference drive without an effect and with it, where it shows most.

    The car is the shipped `rcc` with rolling resistance and drag, which speeds up,
    steers, brakes and stands; an effect of the throttle has the `dart_jetracer`.
    The effect has the value that the car's file states, else that of its typical range
    that suits a small car.
    """
    effect = effect_of(name)[0]
    values, off, on = reference_runs(name, effect)
    shown = most_moved(effect, off, on)
    figure, axes = sheet(len(shown), height=1.5, sharex=True)
    for axis, column in zip(axes, shown, strict=True):
        draw_line(axis, on, column, "on", 1)
        draw_line(axis, off, column, "off", 0)
        name_upright(axis, f"{title_of(column)} [{unit_of(column)}]")
    lines = {line.get_label(): line for line in axes[0].lines}
    told = ", ".join(
        f"{key} = {value:g}" if isinstance(value, float) else f"{key} = {value}"
        for key, value in values.items()
    )
    legend_above(axes[0], [lines["off"], lines["on"]], ["without", told])
    axes[-1].set_xlabel("Time [s]")
    head(figure, effect.title)
    return figure


def reference_runs(
    name: str, effect: Effect
) -> tuple[Mapping[str, float | str], Trace, Trace]:
    """Return the effect's values, and the traces of the drive without and with it."""
    values, bare, with_it = reference_cars(name, effect)
    load = LOAD if "metered" in effect.shows_in else None
    return values, _driven(bare, load), _driven(with_it, load)


def reference_cars(
    name: str, effect: Effect
) -> tuple[Mapping[str, float | str], Vehicle, Vehicle]:
    """Return the effect's values, and the reference car without and with it."""
    by_throttle = "throttle" in effect.shows_in
    car = load_vehicle("dart_jetracer" if by_throttle else "rcc")
    here = {k: v for k, v in BASE.items() if k not in car.effects and not by_throttle}
    files = (name,) if name.endswith(".py") else ()
    whole = car.changed(effects=here, files=files)
    values = _values(whole, effect)
    held = (*effect.excludes, effect.id, *HELD_BY.get(effect.id, ()))
    gone = [n for n in held if n in whole.effects]
    bare = whole.changed(without=tuple(gone))
    return values, bare, bare.changed(effects={effect.id: values})


def most_moved(effect: Effect, off: Trace, on: Trace) -> list[str]:
    """Return channels that differ, as a share of their own range: its own, then most.

    Its own are those that the effect names. Where nothing moves, there are two.
    """
    moved = {
        column: float(
            np.sqrt(np.mean((on[column] - off[column]) ** 2))
            / max(np.ptp(off[column]), np.ptp(on[column]), 1e-9)
        )
        for column in CHANNELS
        if column in on and column in off
    }
    own = [c for c in effect.channels if c in moved]
    order = sorted(moved, key=lambda c: (c not in own, -moved[c]))
    most = [c for c in order if moved[c] > SEEN][:PANELS] or order[:2]
    return [column for column in CHANNELS if column in most]


def _values(car: Vehicle, effect: Effect) -> dict[str, float | str]:
    stated = car.effects.get(effect.id, {})
    if stated:
        return {
            key: figure.value if isinstance(figure, Stated) else figure
            for key, figure in stated.items()
        }
    if effect.id in SMALL:
        return dict(SMALL[effect.id])
    needed = [p for p in effect.params if not p.optional] or list(effect.params)
    return {
        p.name: p.typical[0] if p.typical[0] != p.neutral else p.typical[1]
        for p in needed
    }


def _driven(car: Vehicle, load: Profile | None) -> Trace:
    if car.mode == "throttle":
        time = np.linspace(0.0, 12.0, 1201)
        throttle: NDArray[np.float64] = np.interp(
            time, [0, 1, 5, 6, 8, 9, 12], [0, 0.1, 0.3, 0.3, 0.15, 0, 0]
        )
        log = Trace({"time_s": time, "throttle": throttle})
        cycle, profile = throttle_drive(log)
        return simulate(car, cycle, throttle=profile).trace
    drive = Cycle(
        "reference",
        np.array([0.0, 1, 4, 8, 10, 14, 16, 18]),
        np.array([0.0, 0, 4, 4, 6, 6, 0, 0]),
    )
    time = np.linspace(0.0, 18.0, 1801)
    angle = np.where((time > 5) & (time < 14), 0.03 * np.sin(np.pi * (time - 5)), 0.0)
    steer = time, angle
    run = simulate(car, drive, steer=steer, aux_power=load, output_rate=100.0)
    return run.trace
