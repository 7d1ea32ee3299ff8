"""Measured efficiency of motor and inverter, in place of the single loss terms."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param
from rcc_sim.physics.tables import bilinear

ETA_MIN = 0.02  # 1; no map is believed below this: it would ask for endless power


@jit
def outside_map(tau, omega, map_tau, map_omega):
    """Tell whether |tau| [N m] or omega [rad/s] lies outside the measured grid."""
    return abs(tau) > map_tau[-1] or omega > map_omega[-1]


@jit
def map_efficiency(tau, omega, scale, map_tau, map_omega, map_eta):
    """Efficiency [1] at shaft torque tau [N m] and speed omega [rad/s].

    Bilinear in the measured grid, clamped at its edge; ``scale`` multiplies it.
    """
    return max(scale * bilinear(abs(tau), omega, map_tau, map_omega, map_eta), ETA_MIN)


@jit
def conversion_loss(P_shaft, eta):
    """Loss [W] at shaft power P_shaft [W]: P/η - P motoring, |P| (1 - η) braking."""
    if eta == 1.0:
        return 0.0
    if P_shaft >= 0.0:
        return P_shaft / eta - P_shaft
    return P_shaft * eta - P_shaft


EFFECT = Effect(
    id="motor_efficiency",
    title="efficiency of motor and inverter",
    equation="P_elec = tau omega / eta when motoring, tau omega eta when braking; "
    "eta = scale * map(|tau|, omega)",
    params=(
        Param(
            "scale",
            neutral=1.0,
            bounds=(0.05, 1.2),
            typical=(0.6, 0.97),
            about="factor on the map, whose edge holds beyond it; without a map the "
            "efficiency itself. Nothing is lost at no torque: what drags a coasting "
            "motor is the driveline's",
            optional=True,
        ),
    ),
    files=("map",),
    channels=("battery_power_w", "battery_current_a"),
    sink="motor_efficiency",
    excludes=("copper_loss", "iron_loss"),
    seen_as="battery power short in proportion to shaft power, both ways",
    source="S. Kumari et al., Development of a scaled setup, figs. of motor maps; "
    "P_b = tau omega / eta when motoring",
    sums=("copper_loss", "iron_loss"),
    also=("inverter efficiency",),
)
