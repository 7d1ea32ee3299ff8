"""A trailer on a string: a force that grows with speed, and with the climb.

    rccsim simulate rcc --cycle 'udds[0:130]' --effect trailer.py \
        --with trailer:mass_kg=0.5 --csv | rccsim energy -

A function named ``force`` returns newtons that hold the vehicle back; ``torque``
(N m on the motor's shaft) and ``power`` (W from the battery) work alike. Each takes by
name what it needs of t, s, v, omega, a, slope, and its own parameters. ``sensed``
changes columns of the log instead. At neutral all must vanish.
"""

import math

from rcc_sim.physics.effect import Effect, Param

G = 9.80665  # m/s²


def force(v, a, slope, mass_kg, coefficient):
    """Force [N] of a trailer that rolls, climbs and is sped up."""
    rolling = coefficient * mass_kg * G * math.tanh(v / 0.05)
    return rolling + mass_kg * (G * slope + a)


EFFECT = Effect(
    id="trailer",
    title="trailer on a string",
    equation="F = m (C g tanh(v / 0.05) + g slope + a)",
    params=(
        Param(
            "mass_kg",
            neutral=0.0,
            bounds=(0.0, 5000.0),
            typical=(0.1, 1500.0),
            about="mass of the trailer",
        ),
        Param(
            "coefficient",
            neutral=0.02,
            bounds=(0.0, 0.3),
            typical=(0.006, 0.05),
            about="rolling resistance of its wheels",
            optional=True,
        ),
    ),
    channels=("motor_current_a", "battery_power_w"),
    seen_as="more current whenever the vehicle speeds up or climbs",
    source="Newton's second law, for the trailer alone",
)
