"""Driven tyres that must slip to push: the wheels get a speed of their own."""

import math
from math import inf

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought

LOCKED = -0.9  # 1; an imposed drive that brakes harder has its wheels turn no slower


@jit
def slips(stiffness):
    """Tell whether the driven wheels slip at all: 1 or 0."""
    if stiffness < inf:
        return 1.0
    return 0.0


@jit
def slip_resistance(stiffness, v, v_slip):
    """Force per slip speed [N s/m] at road speed v [m/s]: C / v, kept below C / v_slip.

    F = C kappa with kappa = (omega / n - v) / v, the floor as for the slip angle.
    """
    return stiffness / math.sqrt(v * v + v_slip * v_slip)


@jit
def pushed(push, K, M, k, m, dt):
    """Force [N] on the road at the end of a step, wheels and vehicle both moving.

    Solves M (w1 - w0)/dt = n T - F/k, m (v1 - v0)/dt = F - R and F = K (w1 - v1) for F,
    with push = k (n T + M R/m + M (w0 - v0)/dt): implicit in the slip, which dies out
    in M/K, far less than a step.
    """
    return push / (1.0 + k * M / m + k * M / (K * dt))


@jit
def spun(push, K, M, k, dt):
    """The same where the vehicle stands: push = k (n T + M w0/dt), F = K w1."""
    return push / (1.0 + k * M / (K * dt))


@jit
def imposed_slip(F, stiffness):
    """Slip [1] of wheels that push F [N]: F / C, and no more backwards than LOCKED."""
    return max(F / stiffness, LOCKED)


@jit
def road_speed(w_1, v_0, m, dt, F, C):
    """Road speed [m/s] at the end of a step at which the driven wheels turn at w_1.

    Solves w_1 = v_1 (1 + F_1/C), F_1 = F + m (v_1 - v_0)/dt, for v_1: the road's speed
    comes to the wheels' in a time m v / C. F [N] is what they push without the mass m
    [kg] that they move.
    """
    A = m / (C * dt)
    B = 1.0 + (F - m * v_0 / dt) / C
    root = math.sqrt(B * B + 4.0 * A * w_1)
    if B > 0.0:
        return 2.0 * w_1 / (B + root)
    return 0.5 * (root - B) / A


@jit
def lock_loss(m, M, slip):
    """Energy [J] lost as wheels of inertia M [kg] and a vehicle of m [kg] join.

    They part by the slip speed [m/s] and take the speed that keeps their momentum.
    """
    return 0.5 * m * M / (m + M) * slip * slip


EFFECT = Effect(
    id="longitudinal_slip",
    title="longitudinal slip of the driven tyres",
    equation="F_x = C kappa, kappa = (omega r_w / N_d - v) / v",
    params=(
        Param(
            "stiffness_n",
            neutral=inf,
            bounds=(10.0, inf),
            typical=(100.0, 1e6),
            about="slip stiffness C of the driven tyres together; about 10 to 20 times "
            "the weight on them",
            sought=Sought(tried=(3.0, 6.0, 12.0, 25.0), of="weight", acts="slip"),
        ),
    ),
    channels=("speed_mps", "motor_speed_radps"),
    sink="longitudinal_slip",
    seen_as="a motor that runs ahead of the road when it drives hard, and behind when "
    "it brakes",
    source="H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed., 2012, ch. 1 and 8",
    also=("wheel slip", "wheelspin"),
)
