"""Sensorless motors are blind at low speed: no feedback, no command."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought
from rcc_sim.physics.ticks import share_beyond


@jit
def seen_speed(omega, threshold, change):
    """Motor speed [rad/s] that the controller sees: 0 below the threshold.

    It looks once a tick, in which the speed changes by ``change`` [rad/s]; when, no
    one knows. While the speed passes the threshold this is the mean of what it sees.
    """
    if threshold == 0.0:
        return omega
    return omega * share_beyond(abs(omega) - threshold, change)


@jit
def commands_nothing(omega_ref, threshold):
    """Tell whether a reference [rad/s] is too small to command anything."""
    return abs(omega_ref) < threshold


EFFECT = Effect(
    id="speed_dead_zone",
    title="dead zone of the sensorless speed loop",
    equation="omega_seen = 0 where omega is below the threshold, no current where the "
    "reference is; in the tick that passes it, the mean of when the loop may look",
    params=(
        Param(
            "threshold_radps",
            neutral=0.0,
            bounds=(0.0, 1000.0),
            typical=(20.0, 150.0),
            about="motor speed below which the observer gives nothing",
            sought=Sought(
                tried=(0.01, 0.02, 0.03, 0.045, 0.06, 0.09, 0.13),
                of="motor_speed",
                acts="steps",
            ),
        ),
    ),
    channels=("motor_current_a", "battery_power_w"),
    seen_as="a current spike at every launch, nothing at creeping references",
    source="S. Kumari et al., Development of a scaled setup, appendix A.4",
    shows_in=("commanded", "speed_loop"),
)
