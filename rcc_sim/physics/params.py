"""What the kernel reads and writes, by name: parameters, state, flows, sinks."""

from __future__ import annotations

from rcc_sim.physics.effects import EFFECTS
from rcc_sim.physics.record import Schema, floats

SPEED, TORQUE, THROTTLE = 0.0, 1.0, 2.0
"""Modes of the controller."""

STRAIGHT, LOGGED, FOLLOW, TURNED = 0.0, 1.0, 2.0, 3.0
"""Where the steering angle comes from: nowhere, a log, the path follower, the yaw rate
of a log."""

PARAMS: Schema = {
    "body": floats("m", "I_z", "l_F", "l_R"),
    "tyre": floats("C_F", "C_R", "r_w"),
    "drive": floats("N_d"),
    "motor": floats("K_t", "tau_max", "P_max", "omega_max", "psi"),
    "battery": floats("u_0"),
    "control": floats("mode", "K_p", "K_i", "i_max", "T_loop", "T_driver", "delta_max"),
    "lanes": floats("steer", "every", "width", "length"),
    **{name: floats(*effect.neutral) for name, effect in EFFECTS.items()},
}
"""Parameters of a run: the vehicle's figures, and one table per effect."""

CHASSIS: Schema = floats(
    "m", "I_z", "l_F", "l_R", "l", "C_F", "C_R", "D_F", "D_R",
    "sigma", "n", "n_file", "J", "m_spin", "spin", "K_t", "tau_min", "i_min", "i_max",
    "v_slip", "slips", "t_char", "force_share", "steer_share", "E_0", "E_rotor_0",
    "booked", "per_m", "per_spin", "rotor_share", "per_P_max",
)  # fmt: skip
"""Constants of a run, worked out once from the parameters by ``step.prepare``.

``booked`` is 0 where nobody asks for places and for the energy ledger.
"""

STATE: Schema = floats(
    "t", "v_x", "v_y", "r", "w", "x", "y", "psi", "s", "z", "a_x", "integral",
    "play", "angle", "drift", "alpha_F", "alpha_R", "tau", "ref_at",
    "heard_at", "steer_at", "throttle_at", "grade_at", "aux_at",
)  # fmt: skip
"""What the vehicle carries from step to step; the last six are places in tables."""

INPUTS: Schema = floats(
    "v_sent", "v_ref", "a_ref", "throttle", "tau", "brake", "steer", "delta",
    "sin_delta", "cos_delta", "yaw_rate", "slope", "aux", "wind",
    "cell", "from_t", "per_s", "least", "steer_0", "steer_1", "steer_2", "steer_3",
)  # fmt: skip
"""What acts on the vehicle during one step; last, how a log's steering runs there."""

FORCES: Schema = floats(
    "roll", "aero", "grade", "road", "scrub", "ground", "visc", "dry", "iron",
    "F_F", "F_R", "v_y", "r", "a", "v", "T_L", "k", "moving", "w", "w_1", "slides",
    "pull", "twist", "draw",
)  # fmt: skip
"""Forces [N] and shaft torques [N m] at the middle of one step."""

FLOW: Schema = floats(
    "dt", "a_x", "a_y", "i_q", "tau", "P", "i", "u", "aux", "E", "E_abs", "short",
    "limited", "tau_over", "P_over", "outside", "slip",
)  # fmt: skip
"""Time integrals since the last row, and what went beyond the vehicle's means."""

ROW: Schema = floats(
    "t", "v_ref", "throttle", "steer", "v", "w", "r", "a_x", "a_y", "i_q", "tau",
    "u", "i", "P", "x", "y", "psi", "z", "slope", "aux", "s", "E",
)  # fmt: skip
"""One row of the trace: samples, and means since the row before."""

SINKS: tuple[str, ...] = (
    "kinetic",
    *(effect.sink for effect in EFFECTS.values() if effect.sink),
    "tyre_slip_front",
    "tyre_slip_rear",
    "brakes",
)
"""Lines of the energy ledger, in the order that reports give them."""
