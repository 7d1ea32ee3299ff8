"""Tyres that must roll some way before they carry the force of a new slip angle."""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought

SHORT = 1e-4  # 1; lengths rolled below which the share grows in proportion


@jit
def taken_up(way, length):
    """Share [1] of a change of slip angle that is felt after rolling `way` [m]."""
    if length <= 0.0:
        return 1.0
    return 1.0 - math.exp(-way / length)


@jit
def mean_taken_up(way, length):
    """Mean over `way` [m] of the share [1] of a change that is felt."""
    if length <= 0.0:
        return 1.0
    lengths = way / length
    if lengths < SHORT:
        return 0.5 * lengths
    return 1.0 + math.expm1(-lengths) / lengths


@jit
def felt_slip(held, alpha, share):
    """Slip angle [rad] that makes force: what was held, moved by a share to alpha."""
    if share >= 1.0:
        return alpha
    return held + share * (alpha - held)


EFFECT = Effect(
    id="tyre_relaxation",
    title="relaxation length of the tyres",
    equation="sigma dalpha'/dt + v alpha' = v alpha; force by alpha'",
    params=(
        Param(
            "length_m",
            neutral=0.0,
            bounds=(0.0, 5.0),
            typical=(0.02, 0.8),
            about="relaxation length sigma",
            sought=Sought(tried=(0.05, 0.12, 0.3, 0.6, 1.0), of="wheelbase"),
        ),
    ),
    channels=("yaw_rate_radps", "accel_y_mps2"),
    seen_as="lateral force that lags the steer by a distance, not by a time",
    source="H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed., 2012, ch. 7; the slip "
    "loss then holds what the tyre's spring takes and gives back",
    also=("relaxation length",),
)
