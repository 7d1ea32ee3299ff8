"""From a vehicle's edge names to the kernel's symbols: the one place of the mapping."""

from __future__ import annotations

from math import inf, sqrt
from typing import TYPE_CHECKING

from rcc_sim.definitions import library
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.physics.effects.rotor_inertia import reflected_mass
from rcc_sim.physics.params import SPEED, STRAIGHT, THROTTLE, TORQUE
from rcc_sim.physics.powertrain import torque_constant

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MODES = {"speed": SPEED, "torque": TORQUE, "throttle": THROTTLE}

LOOP_RATE = {"speed": 1000.0, "torque": 100.0, "throttle": 1000.0}
"""Rate of the control loop where the file states none. [Hz]"""

NEUTRAL = {name: effect.neutral for name, effect in EFFECTS.items()}
"""What each shipped effect is where a file does not state it."""

DRIVER_TIMES = 1.0
"""Time constant of a driver not stated in the file, in times sqrt(m l / C_F)."""


def kernel_params(vehicle: Vehicle, *, commanded: bool) -> dict[str, dict[str, float]]:
    """Return the kernel's parameters of a vehicle; what it does not state is ideal.

    Parameters
    ----------
    vehicle : Vehicle
        The definition.
    commanded : bool
        Whether its controller is to drive (then the file must state one).

    Raises
    ------
    InputError
        If a figure that this kind of run needs is missing; names the key and why.
    """
    for name in vehicle.effects:
        effect, why = vehicle.known[name], f"effects.{name} needs it"
        _require(vehicle, effect.needs, why)
        if not any(map(vehicle.states, effect.needs_any)):
            _require(vehicle, effect.needs_any[:1], why)
    _check_loading(vehicle)
    body, tyres = vehicle.body, vehicle.tyres
    return {
        "body": {
            "m": body.mass_kg.value,
            "I_z": body.yaw_inertia_kgm2.value,
            "l_F": body.cg_to_front_axle_m.value,
            "l_R": body.cg_to_rear_axle_m.value,
        },
        "tyre": {
            "C_F": tyres.front_cornering_stiffness_n_per_rad.value,
            "C_R": tyres.rear_cornering_stiffness_n_per_rad.value,
            "r_w": tyres.radius_m.value,
        },
        "drive": {"N_d": vehicle.drivetrain.gear_ratio.value},
        "motor": {
            "K_t": motor_torque_constant(vehicle) or 0.0,
            "tau_max": _largest_torque(vehicle),
            "P_max": _value(vehicle.motor.max_power_w, inf),
            "omega_max": top_motor_speed(vehicle),
            "psi": _phase_linkage(vehicle),
        },
        "battery": {"u_0": open_circuit_voltage(vehicle) or 1.0},
        "control": _control(vehicle, commanded),
        "lanes": {"steer": STRAIGHT, "every": inf, "width": 0.0, "length": 1.0},
        **_effects(vehicle),
    }


def _check_loading(vehicle: Vehicle) -> None:
    """Raise if a payload takes the whole mass, or the CG leaves the axles."""
    body, stated = vehicle.body, vehicle.figures()
    payload = stated.get("effects.payload.mass_kg")
    if payload and body.mass_kg.value + payload.value <= 0:
        raise InputError(
            f"{vehicle.where}: effects.payload.mass_kg: takes more than the vehicle "
            f"weighs, {body.mass_kg.value:g} kg: {payload.value:g}"
        )
    shift = stated.get("effects.cg_shift.shift_m")
    l_F, l_R = body.cg_to_front_axle_m.value, body.cg_to_rear_axle_m.value
    if shift and not -l_R < shift.value < l_F:
        raise InputError(
            f"{vehicle.where}: effects.cg_shift.shift_m: should keep the CG between "
            f"the axles, {-l_R:g} to {l_F:g} m: {shift.value:g}"
        )


def motor_torque_constant(vehicle: Vehicle) -> float | None:
    """Return 3/2 N_p/2 λ [N m/A], or None where the file does not state both."""
    motor = vehicle.motor
    if motor.poles is None or motor.flux_linkage_wb is None:
        return None
    return float(torque_constant(motor.poles, motor.flux_linkage_wb.value))


def top_motor_speed(vehicle: Vehicle) -> float:
    """Return the speed limit of motor and controller [rad/s]; infinite if none."""
    motor, control = vehicle.motor, vehicle.controller
    electrical = control.max_electrical_speed_radps if control else None
    by_controller = inf
    if electrical is not None and motor.poles is not None:
        by_controller = electrical.value / (motor.poles / 2)
    return min(_value(motor.max_speed_radps, inf), by_controller)


def _phase_linkage(vehicle: Vehicle) -> float:
    """Voltage per motor speed, N_p/2 λ [V s]; 0 where no voltage limits the motor.

    That is where battery or motor is unknown, and where the file states the motor's
    power: the envelope of torque then holds the voltage and any field weakening.
    """
    motor, control = vehicle.motor, vehicle.controller
    if control is not None and control.mode != "speed" and motor.max_power_w:
        return 0.0
    if motor.poles is None or motor.flux_linkage_wb is None:
        return 0.0
    known = open_circuit_voltage(vehicle) is not None
    return motor.poles / 2 * motor.flux_linkage_wb.value if known else 0.0


def open_circuit_voltage(vehicle: Vehicle) -> float | None:
    """Return the battery's open-circuit (else nominal) voltage [V], or None."""
    battery = vehicle.battery
    found = battery.open_circuit_voltage_v or battery.nominal_voltage_v
    return found.value if found else None


def efficiency_map(
    vehicle: Vehicle,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the motor's map: torque [N m], speed [rad/s], efficiency; 1 if none."""
    import numpy as np

    name = vehicle.effects.get("motor_efficiency", {}).get("map")
    if not isinstance(name, str):
        return np.zeros(1), np.zeros(1), np.ones((1, 1))
    from rcc_sim.definitions.motor_map import read_motor_map

    return read_motor_map(library.named_by(vehicle.path, name))


def road_of(
    vehicle: Vehicle,
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return distance [m] and slope of the road that the file states, if any.

    ``effects.road_grade.profile`` names a CSV of ``distance_m,slope`` that counts from
    the start of a drive and comes on top of the constant slope.
    """
    name = vehicle.effects.get("road_grade", {}).get("profile")
    if not isinstance(name, str):
        return None
    from rcc_sim.trace import read_trace

    road = read_trace(library.named_by(vehicle.path, name), along="distance_m")
    return road["distance_m"], road["slope"]


def check_throttle(vehicle: Vehicle, *, given: bool) -> None:
    """Raise unless a throttle is given to a vehicle that is driven by one.

    Raises
    ------
    InputError
        If the mode is throttle and there is no log of it, or the other way round.
    """
    by_throttle = vehicle.mode == "throttle"
    if by_throttle and not given:
        raise InputError(
            f"{vehicle.where}: controller.mode: a throttle cannot follow a cycle",
            "give --throttle-log, or --imposed to take the cycle's speed as it is",
        )
    if given and not by_throttle:
        raise InputError(f"{vehicle.where}: controller.mode: should be throttle")


def check_slip(
    vehicle: Vehicle, values: dict[str, dict[str, float]], v_max: float
) -> None:
    """Raise if the speed loop outruns the wheels that slip, and would chatter.

    Within a tick the loop turns the wheels by g = n² K_t K_p / (J n²/T + C/v) times the
    speed that it read less; from g = 1 on each tick overshoots the one before.

    Raises
    ------
    InputError
        If g reaches 1 at the drive's top speed v_max [m/s].
    """
    C = values["longitudinal_slip"]["stiffness_n"]
    if values["control"]["mode"] != SPEED or not 0 < C < inf or v_max <= 0:
        return
    n = values["drive"]["N_d"] / (
        values["tyre"]["r_w"] * values["wheel_radius"]["scale"]
    )
    K_p = values["control"]["K_p"] * values["speed_loop"]["proportional_scale"]
    M = values["rotor_inertia"]["inertia_kgm2"] * n * n
    held = M / values["control"]["T_loop"] + C / v_max
    gain = n * n * values["motor"]["K_t"] * K_p / held
    if gain >= 1:
        raise InputError(
            f"{vehicle.where}: effects.longitudinal_slip.stiffness_n: too small "
            f"for the speed loop at {v_max:.3g} m/s, the wheels would chatter: {C:g}",
            "state effects.rotor_inertia, which holds the wheels"
            if M == 0
            else f"{C * gain:.3g} N would do, or a smaller proportional gain",
        )


def force_table(
    vehicle: Vehicle,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return throttle (n,) [1], speed (k,) [m/s] and wheel force (n, k) [N].

    Raises
    ------
    InputError
        If the table of a vehicle in throttle mode is missing or not rectangular.
    """
    import numpy as np

    control = vehicle.controller
    if control is None or control.mode != "throttle":
        return np.zeros(2), np.zeros(2), np.zeros((2, 2))
    where = f"{vehicle.where}: controller"
    parts = (control.force_throttle, control.force_speed_mps, control.force_n)
    if any(part is None for part in parts):
        raise InputError(
            f"{where}.force_n: missing (throttle mode needs it)",
            "give force_throttle, force_speed_mps and force_n, a row a throttle",
        )
    throttle, speed = (np.array(part, dtype=float) for part in parts[:2])
    rows = control.force_n or []
    if len(rows) != len(throttle) or any(len(row) != len(speed) for row in rows):
        raise InputError(
            f"{where}.force_n: should have {len(throttle)} rows of {len(speed)}"
        )
    for key, grid in (("force_throttle", throttle), ("force_speed_mps", speed)):
        if len(grid) < 2 or (np.diff(grid) <= 0).any():
            raise InputError(f"{where}.{key}: should hold two or more rising figures")
    scale = _value(control.force_scale, 1.0)
    return throttle, speed, scale * np.array(rows, dtype=float)


def _control(vehicle: Vehicle, commanded: bool) -> dict[str, float]:
    control = vehicle.controller
    if control is None:
        if commanded:
            raise InputError(
                f"{vehicle.where}: [controller]: missing (a commanded run needs it)",
                "state [controller] mode, or run with --imposed",
            )
        return {"mode": TORQUE, "i_max": inf, "T_loop": 1.0, "delta_max": inf}
    if commanded and control.mode == "speed":
        needs = (
            "motor.flux_linkage_wb",
            "controller.proportional_gain_as_per_rad",
            "controller.integral_gain_a_per_rad",
            "controller.max_current_a",
            "motor.poles",
        )
        _require(vehicle, needs, "the speed loop needs it")
    rate = _value(control.loop_rate_hz, LOOP_RATE[control.mode])
    return {
        "mode": MODES[control.mode],
        "K_p": _value(control.proportional_gain_as_per_rad, 0.0),
        "K_i": _value(control.integral_gain_a_per_rad, 0.0),
        "i_max": _value(control.max_current_a, inf),
        "T_loop": 1.0 / rate,
        "T_driver": _value(control.driver_time_constant_s, _driver_time(vehicle)),
        "delta_max": _value(control.max_steer_rad, inf),
    }


def _driver_time(vehicle: Vehicle) -> float:
    return DRIVER_TIMES * answering_time(vehicle)


def answering_time(vehicle: Vehicle) -> float:
    """Return the time in which a vehicle answers its steering, sqrt(m l / C_F). [s]"""
    C_F = vehicle.tyres.front_cornering_stiffness_n_per_rad.value
    return sqrt(vehicle.body.mass_kg.value * vehicle.wheelbase / C_F)


def forgetting_time(vehicle: Vehicle, speed: float) -> float:
    """Return the time after which a vehicle turns by its steering alone, m v / C_F.

    At a speed [m/s]. A turn dies away as exp(-4 C t / (m v)), with C that of each of
    the four tyres, and is then a fiftieth of what it was. [s]
    """
    C_F = vehicle.tyres.front_cornering_stiffness_n_per_rad.value
    return vehicle.body.mass_kg.value * speed / C_F


def loop_stiffness(vehicle: Vehicle) -> float:
    r"""Return the rate at which a vehicle's speed loop holds its speed. [1/s]

    .. math:: K_p K_t n^2 / (m + J n^2)

    Nil where it has none, or where the file does not state its gain or its motor.
    """
    control, K_t = vehicle.controller, motor_torque_constant(vehicle)
    gain = control.proportional_gain_as_per_rad if control else None
    if vehicle.mode != "speed" or gain is None or K_t is None:
        return 0.0
    n = vehicle.rad_per_m
    J = _value(vehicle.figures().get("effects.rotor_inertia.inertia_kgm2"), 0.0)
    M = vehicle.body.mass_kg.value + reflected_mass(J, n)
    return float(gain.value * K_t * n**2 / M)


def _effects(vehicle: Vehicle) -> dict[str, dict[str, float]]:
    found = {name: dict(neutral) for name, neutral in NEUTRAL.items()}
    for name, params in vehicle.effects.items():
        effect = vehicle.known[name]
        if name in EFFECTS or not effect.sensor:
            stated = {k: x.value for k, x in params.items() if isinstance(x, Figure)}
            found[name] = effect.neutral | stated
    return found


def _largest_torque(vehicle: Vehicle) -> float:
    asked = vehicle.controller.max_torque_nm if vehicle.controller else None
    return min(_value(asked, inf), _value(vehicle.motor.max_torque_nm, inf))


def _require(vehicle: Vehicle, keys: tuple[str, ...], why: str) -> None:
    for key in keys:
        if not vehicle.states(key):
            vehicle.figure(key, why)  # raises


def _value(figure: Figure | None, default: float) -> float:
    return figure.value if figure is not None else default
