"""From the kernel's rows to the trace's columns: symbols to edge names."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.kernel import open_circuit_voltage
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.physics.powertrain import dq_voltages
from rcc_sim.physics.record import column

Array = NDArray[np.float64]

OF_EVERY_CAR = {
    "speed_ref_mps": "v_ref",
    "steer_cmd_rad": "steer",
    "speed_mps": "w",
    "yaw_rate_radps": "r",
    "accel_x_mps2": "a_x",
    "accel_y_mps2": "a_y",
    "motor_torque_nm": "tau",
    "motor_speed_radps": "w",
}
OF_CURRENT = dict.fromkeys(("motor_current_a", "current_q_a", "current_d_a"), "i_q")
OF_BATTERY = {"battery_voltage_v": "u", "battery_current_a": "i"}
OF_POWER = {"battery_power_w": "P"}
OF_THE_DRIVE = {
    "throttle": "throttle",
    "aux_power_w": "aux",
    "slope": "slope",
    "elevation_m": "z",
}
"""Columns of a log -> what the kernel's rows hold of them: of every car, of one whose
motor's constants are known, of one whose battery is; of the drive, where not nil."""


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
    vehicle: Vehicle,
    rows: Any,
    *,
    n: float,
    n_file: float,
    K_t: float,
    only: Collection[str] = (),
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
    only : collection of str
        Columns that are wanted, beside ``time_s``; all where empty.
    """
    times = {"speed_mps": n / n_file, "motor_speed_radps": n, "current_d_a": 0.0}

    def read(fields: Mapping[str, str]) -> dict[str, Array]:
        wanted = {c: of for c, of in fields.items() if not only or c in only}
        found = {name: column(rows, symbol) for name, symbol in wanted.items()}
        return {c: x * times[c] if c in times else x for c, x in found.items()}

    out = {"time_s": column(rows, "t")} | read(OF_EVERY_CAR)
    if K_t > 0:
        out |= read(OF_CURRENT)
        if not only:
            w = column(rows, "w")
            omega = np.concatenate([w[:1], 0.5 * (w[1:] + w[:-1])]) * n
            out |= _voltages(vehicle, out["current_q_a"], omega)  # means, both
    if open_circuit_voltage(vehicle) is not None:
        out |= read(OF_BATTERY)
        if "battery_voltage_v" in out:
            out["battery_voltage_v"][0] = open_circuit_voltage(vehicle)
    out |= read(OF_POWER)
    return out | {c: x for c, x in read(OF_THE_DRIVE).items() if np.any(x)}


def _voltages(vehicle: Vehicle, i_q: Array, omega: Array) -> dict[str, Array]:
    motor = vehicle.motor
    resistance = vehicle.effects.get("copper_loss", {}).get("phase_resistance_ohm")
    if motor.average_inductance_h is None:
        return {}
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
    return {"voltage_d_v": V_d, "voltage_q_v": V_q}
