"""Tyres that reach the limit of their grip."""

import math
from math import inf

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought

SHAPE = 1.3  # 1; shape factor C of the magic formula for lateral force
NEAR_PEAK = 0.999  # 1; share of the peak force beyond which a tyre slides


@jit
def tyre_force(alpha, C, D):
    """Lateral force [N] of one tyre that opposes slip angle alpha [rad].

    D sin(1.3 atan(C α / (1.3 D))) with stiffness C [N/rad] and peak D [N]; a peak
    without limit is the linear tyre C α.
    """
    if D == inf:
        return C * alpha
    return D * math.sin(SHAPE * math.atan(C * alpha / (SHAPE * D)))


@jit
def tyre_stiffness(alpha, C, D):
    """Slope [N/rad] of :func:`tyre_force` at slip angle alpha [rad]."""
    if D == inf:
        return C
    x = C * alpha / (SHAPE * D)
    return C * math.cos(SHAPE * math.atan(x)) / (1.0 + x * x)


@jit
def slip_angle(F, C, D):
    """Slip angle [rad] at which one tyre carries F [N]: the inverse of tyre_force.

    Beyond the peak there is no such angle; the one just short of it is returned.
    """
    if D == inf:
        return F / C
    part = min(max(F / D, -NEAR_PEAK), NEAR_PEAK)
    return SHAPE * D / C * math.tan(math.asin(part) / SHAPE)


EFFECT = Effect(
    id="tyre_saturation",
    title="limit of grip",
    equation="F_y = D sin(1.3 atan(C alpha / (1.3 D))), D = mu F_z",
    params=(
        Param(
            "friction_coefficient",
            neutral=inf,
            bounds=(0.05, inf),
            typical=(0.4, 1.1),
            about="peak lateral force over the static wheel load",
            sought=Sought(tried=(0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0)),
        ),
    ),
    channels=("yaw_rate_radps", "accel_y_mps2"),
    seen_as="yaw rate and lateral acceleration that stop growing with steer",
    source="H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed., 2012, ch. 4",
    shows_in=("steered",),
    also=("grip", "friction coefficient", "mu"),
)
