"""Centre of gravity from scales or a balance point, and the ballast that moves it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from rcc_sim.errors import InputError, require_metres, require_positive
from rcc_sim.identify.uncertainty import Propagated, propagate


@dataclass(frozen=True)
class CentreOfGravity:
    """Where the centre of gravity lies between the axles.

    Attributes
    ----------
    l_F, l_R, l : float
        Distance to the front and the rear axle, and the wheelbase. [m]
    l_F_sd, l_R_sd : float
        Standard deviations. [m]
    m : float or None
        Mass, where scales gave it. [kg]
    budget : Mapping of str to float
        Share of the variance of l_F by input. [1]
    """

    l_F: float
    l_R: float
    l: float
    l_F_sd: float
    l_R_sd: float
    m: float | None
    budget: Mapping[str, float]


@dataclass(frozen=True)
class Ballast:
    """A ballast and the car with it.

    Attributes
    ----------
    mass : float
        Of the ballast. [kg]
    position : float
        Of the ballast, behind the front axle; negative ahead of it. [m]
    l_F, l_R : float
        Of the loaded car. [m]
    m : float
        Of the loaded car. [kg]
    I_z_change : float
        What the ballast adds to the yaw inertia about the centre of gravity. [kg m²]
    I_z : float or None
        Of the loaded car, where that of the bare car was given. [kg m²]
    """

    mass: float
    position: float
    l_F: float
    l_R: float
    m: float
    I_z_change: float
    I_z: float | None


def cg_from_scales(
    l: float, front: float, rear: float, *, l_sd: float = 0.0, scale_sd: float = 0.0
) -> CentreOfGravity:
    r"""Centre of gravity from what each axle weighs on level ground.

    .. math:: l_F = l\,m_R / (m_F + m_R), \qquad l_R = l - l_F

    from the moments about the front axle. [1]_

    Parameters
    ----------
    l : float
        Wheelbase. [m]
    front, rear : float
        What the scales read under each axle, both wheels together. [kg]
    l_sd, scale_sd : float, optional
        Standard deviation of the wheelbase and of one axle's reading. [m], [kg]

    Returns
    -------
    CentreOfGravity
        With the mass, the sum of the readings.

    Raises
    ------
    InputError
        If an argument is not finite and positive.

    References
    ----------
    .. [1] T. D. Gillespie, Fundamentals of Vehicle Dynamics, SAE, 1992, ch. 1.
    """
    require_positive(wheelbase=l, front=front, rear=rear)
    require_metres(wheelbase=l)
    values = {"l": l, "front": front, "rear": rear}
    sds = {"l": l_sd, "front": scale_sd, "rear": scale_sd}
    to_front = propagate(_behind_front_axle, values, sds)
    to_rear = propagate(
        _behind_front_axle, {**values, "front": rear, "rear": front}, sds
    )
    return CentreOfGravity(
        l_F=to_front.value,
        l_R=to_rear.value,
        l=l,
        l_F_sd=to_front.sd,
        l_R_sd=to_rear.sd,
        m=front + rear,
        budget=to_front.budget,
    )


def cg_from_balance(
    l: float, balance: float, *, l_sd: float = 0.0, balance_sd: float = 0.0
) -> CentreOfGravity:
    """Centre of gravity from the point at which the car balances on an edge.

    Parameters
    ----------
    l : float
        Wheelbase. [m]
    balance : float
        Balance point, behind the front axle. [m]
    l_sd, balance_sd : float, optional
        Standard deviations. [m]

    Returns
    -------
    CentreOfGravity
        Without a mass.

    Raises
    ------
    InputError
        If the balance point does not lie between the axles.
    """
    require_positive(wheelbase=l, balance=balance)
    require_metres(wheelbase=l)
    if balance >= l:
        raise InputError(
            f"balance: should lie between the axles, 0 to {l:g} m: {balance:g}",
            "measure from the front axle, in metres",
        )
    moved = propagate(
        lambda l, balance: l - balance,
        {"l": l, "balance": balance},
        {"l": l_sd, "balance": balance_sd},
    )
    budget = {"balance": 1.0} if balance_sd > 0 else {}
    return CentreOfGravity(balance, moved.value, l, balance_sd, moved.sd, None, budget)


def cg_height(
    l: float,
    m: float,
    level: float,
    raised: float,
    lift: float,
    wheel_radius: float,
    *,
    scale_sd: float = 0.0,
    lift_sd: float = 0.0,
) -> Propagated:
    r"""Height of the centre of gravity from tilting the car about one axle.

    .. math:: h = r_w + \frac{(m' - m_0)\,l}{m \tan\theta}, \qquad \sin\theta = H / l

    where the axle that stays down weighs m₀ level and m' with the other raised by H;
    moments about the raised axle. The suspension must be locked, the wheels free. [1]_

    Parameters
    ----------
    l, m : float
        Wheelbase and mass. [m], [kg]
    level, raised : float
        Reading under the axle that stays down: level, and with the other raised. [kg]
    lift : float
        Height H by which the other axle is raised. [m]
    wheel_radius : float
        Height of the axles above the ground when level. [m]
    scale_sd, lift_sd : float, optional
        Standard deviation of a reading and of the lift. [kg], [m]

    Returns
    -------
    Propagated
        Height above the ground, level, with sd and budget. [m]

    Raises
    ------
    InputError
        If an argument is not positive, the lift is not less than the wheelbase, or the
        height found is not above the ground.

    References
    ----------
    .. [1] ISO 10392:2011, "Road vehicles - Determination of centre of gravity."
    """
    require_positive(
        l=l, m=m, level=level, raised=raised, lift=lift, wheel_radius=wheel_radius
    )
    if lift >= l:
        raise InputError(f"lift: should be less than the wheelbase, {l:g} m: {lift:g}")

    def height(level: float, raised: float, lift: float) -> float:
        tangent = math.tan(math.asin(lift / l))
        return wheel_radius + (raised - level) * l / (m * tangent)

    found = propagate(
        height,
        {"level": level, "raised": raised, "lift": lift},
        {"level": scale_sd, "raised": scale_sd, "lift": lift_sd},
    )
    if found.value <= 0:
        raise InputError(
            f"raised: the centre of gravity would lie below the ground,"
            f" {found.value:g} m",
            "both readings belong to the axle that stays down, which gains weight",
        )
    return found


def ballast(
    m: float,
    l_F: float,
    l: float,
    target: float,
    *,
    mass: float | None = None,
    position: float | None = None,
    I_z: float | None = None,
    reach: tuple[float, float] | None = None,
) -> Ballast:
    r"""Ballast that puts the centre of gravity where it is wanted.

    .. math:: (m + m_b)\, l_F' = m\, l_F + m_b\, x

    Give its mass and get its position, or its position and get its mass. As a point
    mass it changes the yaw inertia by the parallel-axis theorem, which for the two
    bodies is :math:`\Delta I_z = (x - l_F)^2\, m\,m_b / (m + m_b)`.

    Parameters
    ----------
    m, l_F, l : float
        Mass, distance of the centre of gravity behind the front axle, wheelbase.
        [kg], [m], [m]
    target : float
        Wanted distance behind the front axle, with the ballast. [m]
    mass, position : float, optional
        Of the ballast; exactly one. Position is behind the front axle. [kg], [m]
    I_z : float, optional
        Yaw inertia of the bare car about its centre of gravity. [kg m²]
    reach : tuple of two float, optional
        Foremost and rearmost place for ballast; the axles unless given. [m]

    Returns
    -------
    Ballast
        The ballast, and the loaded car.

    Raises
    ------
    InputError
        If the target cannot be reached so; says how near one gets, or on which side
        the ballast would have to be.
    """
    require_positive(m=m, l=l, l_F=l_F, target=target)
    if l_F >= l or target >= l:
        raise InputError(
            f"l_F, target: should be less than {l:g} m: {l_F:g}, {target:g}"
        )
    front, rear = reach or (0.0, l)
    if mass is not None and position is None:
        require_positive(mass=mass)
        position = target + m / mass * (target - l_F)
        if not front <= position <= rear:
            end = rear if position > rear else front
            nearest = (m * l_F + mass * end) / (m + mass)
            needed = m * (target - l_F) / (end - target) if end != target else math.inf
            raise InputError(
                f"mass: {mass:g} kg would have to sit {position:.4g} m behind the front"
                f" axle; it can from {front:g} to {rear:g} m, and moves the CG to"
                f" {nearest:.4g} m at most",
                f"{needed:.4g} kg at {end:g} m would do" if needed > 0 else "",
            )
    elif position is not None and mass is None:
        mass = _ballast_mass(m, l_F, target, position, front, rear)
    else:
        raise InputError("mass, position: exactly one of the two is needed")
    total = m + mass
    change = (position - l_F) ** 2 * m * mass / total
    return Ballast(
        mass=mass,
        position=position,
        l_F=target,
        l_R=l - target,
        m=total,
        I_z_change=change,
        I_z=None if I_z is None else I_z + change,
    )


def _ballast_mass(
    m: float, l_F: float, target: float, position: float, front: float, rear: float
) -> float:
    """Mass at the position that puts the centre of gravity on target. [kg]"""
    if not front <= position <= rear:
        raise InputError(
            f"position: should be from {front:g} to {rear:g} m: {position:g}",
            "it is measured behind the front axle, in metres",
        )
    if target == l_F:
        return 0.0
    if (target - l_F) * (position - target) <= 0:
        side = "behind" if target > l_F else "ahead of"
        raise InputError(
            f"position: no mass {position:g} m behind the front axle moves the CG from"
            f" {l_F:g} to {target:g} m",
            f"the ballast has to sit {side} {target:g} m",
        )
    return m * (target - l_F) / (position - target)


def _behind_front_axle(l: float, front: float, rear: float) -> float:
    """Distance of the centre of gravity behind the front axle. [m]"""
    return l * rear / (front + rear)
