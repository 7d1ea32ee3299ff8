"""From the kernel's rows to the trace's columns: symbols to edge names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.kernel import open_circuit_voltage
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.physics.powertrain import dq_voltages
from rcc_sim.physics.record import column

Array = NDArray[np.float64]


def trace_columns(
    vehicle: Vehicle,
    rows: Any,
    sinks: Any,
    lines: Sequence[str],
    *,
    n: float,
    n_file: float,
    K_t: float,
) -> dict[str, Array]:
    """Return the trace of a run: what a log may hold, places, and the energy ledger.

    Parameters
    ----------
    rows, sinks : records
        What the kernel wrote.
    lines : sequence of str
        Lines of the ledger.
    n, n_file, K_t : float
        As for :func:`log_columns`.
    """
    out = log_columns(vehicle, rows, n=n, n_file=n_file, K_t=K_t)
    for name, symbol in (("x_m", "x"), ("y_m", "y"), ("yaw_rad", "psi")):
        out[name] = column(rows, symbol)
    out["distance_m"] = column(rows, "s")
    out["battery_energy_j"] = column(rows, "E")
    for sink in lines:
        joules = column(sinks, sink)
        if sink == "kinetic" or np.any(joules):
            out[f"energy_{sink}_j"] = joules
    return out


def log_columns(
    vehicle: Vehicle, rows: Any, *, n: float, n_file: float, K_t: float
) -> dict[str, Array]:
    """Return what a car's log may hold of a run, column by edge name.

    Speeds and angles are samples at ``time_s``; accelerations, currents, torques,
    voltages and powers are means since the row before.

    Parameters
    ----------
    rows : records
        What the kernel wrote.
    n, n_file : float
        Motor speed over road speed, true and by the file's radius. [1/m]
    K_t : float
        Torque constant; 0 where unknown. [N m/A]
    """
    w = column(rows, "w")
    out = {
        "time_s": column(rows, "t"),
        "speed_ref_mps": column(rows, "v_ref"),
        "steer_cmd_rad": column(rows, "steer"),
        "speed_mps": w * (n / n_file),
        "yaw_rate_radps": column(rows, "r"),
        "accel_x_mps2": column(rows, "a_x"),
        "accel_y_mps2": column(rows, "a_y"),
        "motor_torque_nm": column(rows, "tau"),
        "motor_speed_radps": w * n,
    }
    if K_t > 0:
        omega = np.concatenate([w[:1], 0.5 * (w[1:] + w[:-1])]) * n  # as the currents
        out |= _motor_columns(vehicle, column(rows, "i_q"), omega)
    if open_circuit_voltage(vehicle) is not None:
        out["battery_voltage_v"] = column(rows, "u")
        out["battery_current_a"] = column(rows, "i")
        out["battery_voltage_v"][0] = open_circuit_voltage(vehicle)
    out["battery_power_w"] = column(rows, "P")
    for name, symbol in (
        ("throttle", "throttle"),
        ("aux_power_w", "aux"),
        ("slope", "slope"),
        ("elevation_m", "z"),
    ):
        values = column(rows, symbol)
        if np.any(values):
            out[name] = values
    return out


def _motor_columns(vehicle: Vehicle, i_q: Array, omega: Array) -> dict[str, Array]:
    out = {"motor_current_a": i_q, "current_q_a": i_q, "current_d_a": 0.0 * i_q}
    motor = vehicle.motor
    resistance = vehicle.effects.get("copper_loss", {}).get("phase_resistance_ohm")
    if motor.average_inductance_h is None:
        return out
    half = motor.inductance_difference_h
    L_q = motor.average_inductance_h.value + (half.value / 2 if half else 0.0)
    assert motor.poles is not None and motor.flux_linkage_wb is not None
    V_d, V_q = dq_voltages(
        i_q,
        omega,
        R=resistance.value if isinstance(resistance, Figure) else 0.0,
        L_q=L_q,
        poles=motor.poles,
        flux_linkage=motor.flux_linkage_wb.value,
    )
    return out | {"voltage_d_v": V_d, "voltage_q_v": V_q}
