"""Wheels that scrub as they turn: axles without a differential, above all."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def scrub_force(delta, k):
    """Force [N] that holds a car back whose wheels are turned by delta [rad]."""
    return k * abs(delta)


EFFECT = Effect(
    id="steering_drag",
    title="scrub of turned wheels",
    equation="F = k |delta|",
    params=(
        Param(
            "force_n_per_rad",
            neutral=0.0,
            bounds=(0.0, 5000.0),
            typical=(0.5, 10.0),
            about="force per steering angle k, beside what the tyres' slip takes",
        ),
    ),
    channels=("speed_mps", "motor_current_a", "battery_power_w"),
    sink="steering_drag",
    seen_as="a car that slows in bends by more than its tyres' slip explains",
    source="L. Lyons et al., DART: A Compact Platform for Autonomous Driving "
    "Research, 2024, extra friction of a car without differentials",
    shows_in=("steered",),
    rare=True,
    left_as=("drag", "steer_cmd_rad"),
)
