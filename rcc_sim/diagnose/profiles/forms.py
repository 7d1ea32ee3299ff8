"""How something that no effect of the library holds may act, and what it may follow."""

from __future__ import annotations

from rcc_sim.definitions.vehicle import EFFICIENCY
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.residuals.problem import SINCE_BRAKING, SINCE_STANDING
from rcc_sim.diagnose.residuals.shapes import STIFFNESS, TORQUE

STEERING = "steer_cmd_rad"

EFFICIENT = "efficiency"

CARRIERS = {
    "drag": ("effects.drivetrain_friction.torque_nm", "effects.road_load.a_n"),
    "power": ("effects.auxiliary_load.power_w",),
    "mass": ("effects.payload.mass_kg",),
    "steer": ("effects.steering_offset.angle_rad",),
    "grip": (STIFFNESS[0],),
    EFFICIENT: (EFFICIENCY,),
}
"""How something unknown may act: as a drag, a power, a mass, an angle of the wheels, a
grip or an efficiency that changes; and the figure by which the model is made to do so
(the second, where a file states it)."""

CORNERING = ("steer", "grip")
"""Those of them that show in cornering alone."""

ITSELF = {"auxiliary_load": "power"}
"""Effect -> the way of acting that is its own."""

DRAG_OVER_TIME = ("drag", "time_s")
"""How a rough road acts, and what it follows."""

FEED = "feed"
"""How what a load would have to be below nil acts."""

FOLLOWS = {
    "time_s": (25, 40),
    "speed_mps": (16,),
    STEERING: (16,),
    SINCE_BRAKING: (12, 24),
    SINCE_STANDING: (12, 24),
}
"""What it may follow, and by how many knots."""

AFTER = (SINCE_BRAKING, SINCE_STANDING)
MODELLED = ("speed_mps", TORQUE, *AFTER)
"""Those of them that the model knows where the log has no such column."""

OTHERS: dict[str, dict[str, tuple[int, ...]]] = {
    "grip": {"time_s": (40, 120), "speed_mps": (16,), STEERING: (16,)},
    "mass": {"time_s": (25, 40)},
    EFFICIENT: {TORQUE: (8, 16), "speed_mps": (16,), "time_s": (25, 40)},
}
"""What a grip follows: a patch is short, and no noise of cornering is slow. A mass gets
in and out. And what an efficiency does, as any that was measured, and as what grows
hot."""

CHANGES = {
    "time_s": (4, 8, 16), STEERING: (8, 16),
    SINCE_BRAKING: (12,), SINCE_STANDING: (12,),
}  # fmt: skip
"""What a cause that was taken as constant may change with, and by how many knots."""


def carrier_of(engine: Engine, fit: Fit, name: str) -> str:
    """Return the figure by which the model acts in one of the ``CARRIERS``."""
    known = {**engine.vehicle.figures(), **fit.values}
    tables = {key.rpartition(".")[0] for key in known}
    keys = CARRIERS[name]
    return next((k for k in keys[1:] if k.rpartition(".")[0] in tables), keys[0])
