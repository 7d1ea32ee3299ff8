"""Road load as certified on a track: A + B v + C v², in still air or in wind."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def road_load_force(v_x, v_air, a, b, c):
    """Certified force A + B v + C v² [N] of a rolling vehicle at v_x [m/s].

    Never less than nothing in still air: a fit with a negative part must not push. At
    another speed v_air [m/s] against the air, C v_air |v_air| stands for C v²: what
    grows with the square is taken as the air's, as coast-downs are corrected for wind.
    """
    still = a + b * v_x + c * v_x * v_x
    return 0.5 * (still + abs(still)) + c * (v_air * abs(v_air) - v_x * v_x)


EFFECT = Effect(
    id="road_load",
    title="certified road load",
    equation="F = max(A + B v + C v^2, 0) + C (v_air |v_air| - v^2)",
    params=(
        Param(
            "a_n",
            neutral=0.0,
            bounds=(-100.0, 5000.0),
            typical=(1.0, 250.0),
            about="constant part A",
            optional=True,
        ),
        Param(
            "b_n_s_per_m",
            neutral=0.0,
            bounds=(-50.0, 500.0),
            typical=(-1.0, 12.0),
            about="part B that grows with speed",
            optional=True,
        ),
        Param(
            "c_n_s2_per_m2",
            neutral=0.0,
            bounds=(-1.0, 50.0),
            typical=(0.01, 0.8),
            about="part C that grows with its square",
            optional=True,
        ),
    ),
    channels=("motor_current_a", "battery_power_w"),
    sink="road_load",
    excludes=(
        "rolling_resistance",
        "aerodynamic_drag",
        "drivetrain_damping",
        "drivetrain_friction",
    ),
    seen_as="a coast-down that slows faster than the file says",
    source="SAE J2263 (coast-down); US EPA test-car list, target coefficients",
    sums=(
        "rolling_resistance",
        "aerodynamic_drag",
        "drivetrain_damping",
        "drivetrain_friction",
        "iron_loss",
    ),
    also=("coastdown",),
)
