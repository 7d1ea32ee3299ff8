"""Changes to a car in the words of the workshop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from rcc_sim.similitude.quantities import Interval

CHANGE, OUT = "change", "out of reach"


class Advice(NamedTuple):
    """What can be done: "change" or "out of reach", and how or why."""

    status: str
    how: str


class Frame(NamedTuple):
    """What masses are fixed to.

    Attributes
    ----------
    m, l : float
        Mass [kg] and wheelbase [m] of the car.
    arm : float
        Distance from the CG, fore and aft, at which masses are fixed. [m]
    ratio : float
        I_z/(m l²) that is wanted. [1]
    """

    m: float
    l: float
    arm: float
    ratio: float


def mass_at_arms(I_z: float, frame: Frame) -> float | None:
    r"""Return the mass, half of it fore and half aft, that gives I_z/(m l²) in kg.

    .. math:: I_z + M d^2 = \pi (m + M) l^2

    for M, which counts the mass itself; below 0 it is to be taken away. None where
    masses so near the CG lower the ratio that they should raise.
    """
    gain = frame.arm**2 - frame.ratio * frame.l**2
    if gain <= 0:
        return None
    return (frame.ratio * frame.m * frame.l**2 - I_z) / gain


def cg_place(now: Interval, needed: Interval, frame: Frame) -> Advice:
    """Say how far the CG moves; l_F falls when it moves forward."""
    forward = now.value - needed.value
    where = "forward" if forward > 0 else "back"
    shift = abs(forward)
    mass = frame.m * shift / (2 * frame.arm)
    return Advice(
        CHANGE,
        f"move the CG {shift * 1000:.3g} mm {where}: carry {_grams(mass)} over "
        f"{2 * frame.arm:.3g} m, or shift the battery",
    )


def yaw_inertia(now: Interval, needed: Interval, frame: Frame) -> Advice:
    """Say which masses fore and aft give the inertia; the CG stays."""
    more = needed.value - now.value
    total = mass_at_arms(now.value, frame)
    if more < 0:
        moved = -more / frame.arm**2 / 2
        at_cg = now.value / (frame.ratio * frame.l**2) - frame.m
        return Advice(
            OUT if moved > frame.m / 4 else CHANGE,
            f"{-more:.3g} kg m² too much: mass must go or move inwards, such as two "
            f"masses of {_grams(moved)} from ±{frame.arm:.3g} m to the CG; or add "
            f"{at_cg:.3g} kg at the CG, which lowers the ratio (J and B then too)",
        )
    if total is None:
        return Advice(
            OUT,
            f"masses at ±{frame.arm:.3g} m are too near the CG: fix them at more than "
            f"±{frame.ratio**0.5 * frame.l:.3g} m (--arm)",
        )
    return Advice(
        CHANGE,
        f"add {more:.3g} kg m² of yaw inertia = two masses of "
        f"{_grams(more / frame.arm**2 / 2)} at ±{frame.arm:.3g} m; "
        f"{_grams(total / 2)} each counts that they also add mass",
    )


def rear_stiffness(now: Interval, needed: Interval, frame: Frame) -> Advice:
    """Say how the rear tyres should differ."""
    word = "stiffer" if needed.value > now.value else "softer"
    share = abs(needed.value / now.value - 1)
    return Advice(
        CHANGE, f"rear tyres {share:.0%} {word}: {needed.value:.4g} N/rad each"
    )


def shaft_inertia(now: Interval, needed: Interval, frame: Frame) -> Advice:
    """Say what to put on the motor shaft."""
    more = needed.value - now.value
    if more > 0:
        return Advice(CHANGE, f"add {more:.3g} kg m² at the motor shaft (a flywheel)")
    return Advice(
        OUT,
        f"{needed.value:.3g} kg m² is below the {now.value:.3g} of motor, driveline "
        "and wheels together; only lighter parts bring it down",
    )


def shaft_damping(now: Interval, needed: Interval, frame: Frame) -> Advice:
    """Say what drag to add to the motor shaft."""
    more = needed.value - now.value
    if more > 0:
        return Advice(
            CHANGE,
            f"add {more:.3g} N m s/rad of viscous drag at the motor shaft, such as an "
            "eddy-current brake",
        )
    return Advice(
        OUT,
        f"{needed.value:.3g} N m s/rad is below the {now.value:.3g} of the vehicle's "
        "own driveline; nothing that is added lowers it",
    )


def length(now: Interval, needed: Interval, frame: Frame) -> Advice:
    """Say what a length should be."""
    return Advice(CHANGE, f"{needed.value:.4g} m in place of {now.value:.4g} m")


def mass(now: Interval, needed: Interval, frame: Frame) -> Advice:
    """Say what ballast makes the weight scale as the tyre forces do."""
    more = needed.value - now.value
    if more > 0:
        return Advice(
            CHANGE,
            f"{more:.3g} kg of ballast at the CG, or tyres softer by the factor "
            f"{now.value / needed.value:.3g}",
        )
    return Advice(
        OUT,
        f"{-more:.3g} kg would have to go (ballast cannot be negative); tyres stiffer "
        f"by the factor {now.value / needed.value:.3g} do the same",
    )


def number(now: Interval, needed: Interval, frame: Frame) -> Advice:
    """Say what a figure should be."""
    return Advice(CHANGE, f"{needed.value:.4g} in place of {now.value:.4g}")


WORDS: Mapping[str, Callable[[Interval, Interval, Frame], Advice]] = {
    "l_F": cg_place,
    "I_z": yaw_inertia,
    "C_R": rear_stiffness,
    "J": shaft_inertia,
    "B": shaft_damping,
    "m": mass,
    "h_cg": length,
    "w": length,
    "r_w": length,
    "C_rr": number,
    "C_dA": number,
    "P_aux": number,
}
"""Symbol -> what words its change."""


def _grams(mass: float) -> str:
    return f"{mass:.3g} kg" if mass >= 1 else f"{mass * 1000:.3g} g"
