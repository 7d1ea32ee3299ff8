"""A drive force that builds up gradually."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought
from rcc_sim.physics.effects.steering_lag import mean_lagged


@jit
def mean_force(value, target, share, time_constant, dt):
    """Mean of the drive force over dt [s], on its way from a value to a target.

    The lag makes a share of that way in dt.
    """
    return mean_lagged(value, target, share, time_constant, dt)


EFFECT = Effect(
    id="motor_lag",
    title="lag of the drive force",
    equation="T dtau/dt + tau = command",
    params=(
        Param(
            "time_constant_s",
            neutral=0.0,
            bounds=(0.0, 5.0),
            typical=(0.02, 0.3),
            about="time constant T of the force",
            sought=Sought(tried=(0.01, 0.03, 0.06, 0.1, 0.16)),
        ),
    ),
    channels=("speed_mps", "accel_x_mps2"),
    seen_as="acceleration that rounds the corners of the throttle",
    source="definition; solved exactly for a command held over a tick",
    shows_in=("commanded",),
    also=("motor time constant",),
)
