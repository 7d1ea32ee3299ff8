"""Figures of a vehicle file that no car of any size has: a slip of a unit, likely.

A number that does not grow with size is much the same in a car of 1.6 kg and a truck of
3000, which is why one can stand for the other; a charge in mAh or a stiffness a degree
puts it out by a factor of ten and more. What is told here is not refused: a strange car
is a car. Mass, yaw inertia and wheels that do not go together at all never load.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from math import inf, isfinite, sqrt
from typing import Any, NamedTuple

from rcc_sim.definitions.faults import vehicle_faults
from rcc_sim.definitions.kernel import open_circuit_voltage
from rcc_sim.definitions.vehicle import Vehicle, load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics.effects.rotor_inertia import reflected_mass
from rcc_sim.similitude.envelope import (
    envelope_of,
    speed_by_constant,
    speed_by_linkage,
)
from rcc_sim.units import J_PER_WH, G

CELLS = re.compile(r"\s*(\d+)\s*[sS]")
"""Cells in series, of a configuration: 3 of 3S, 96 of 96S1P."""

DENSEST = 300.0
"""Most energy per mass of a whole vehicle: more than the best cells alone. [Wh/kg]"""


class Ratio(NamedTuple):
    """A number that does not grow with size, and between which ends every car has it.

    Attributes
    ----------
    key : str
        The figure that is likely at fault where the number lies beyond them.
    what : str
        The number in words.
    of : callable
        Number of a vehicle; None if the vehicle does not state what it takes.
    low, high : float
        About three times beyond what the shipped vehicles, 1.6 to 3200 kg, and other
        published ones have.
    hint : str
        The likely mend.
    stated : callable or None
        Which figure of a vehicle it is, where it may be one of several.
    """

    key: str
    what: str
    of: Callable[[Vehicle], float | None]
    low: float
    high: float
    hint: str
    stated: Callable[[Vehicle], str] | None = None

    def told(self, vehicle: Vehicle) -> str:
        """Return what is unlikely about it; empty if nothing is."""
        found = self.of(vehicle)
        if found is None or not isfinite(found) or self.low <= found <= self.high:
            return ""
        usual = f"{self.low:g} to {self.high:g}"
        if not isfinite(self.high):
            usual = f"at least {self.low:g}"
        key = self.stated(vehicle) if self.stated else self.key
        return f"{key}: unlikely: {self.what} is {found:.3g}, usually {usual}"


def unlikely(vehicle: Vehicle) -> list[tuple[str, str]]:
    """Return what is unlikely about a vehicle's figures, each with its likely mend."""
    told = ((ratio.told(vehicle), ratio.hint) for ratio in RATIOS)
    return [(text, hint) for text, hint in told if text]


def report(names: Iterable[str]) -> list[dict[str, Any]]:
    """Return what is wrong with vehicles, and what is unlikely about the sound ones.

    Returns
    -------
    rows : list of dict
        File, whether it is sound, the problem, and a hint: one for each fault, and one
        for a vehicle without any; a name that is nowhere is a fault like any other.
    """
    return [
        {"file": name, "sound": sound, "problem": problem, "hint": hint}
        for name in names
        for sound, problem, hint in _said_of(name)
    ]


def _said_of(name: str) -> list[tuple[bool, str, str]]:
    try:
        faults = vehicle_faults(name)
    except InputError as fault:
        faults = [fault]
    if faults:
        return [(False, str(fault), fault.hint) for fault in faults]
    odd = [(True, what, hint) for what, hint in unlikely(load_vehicle(name))]
    return odd or [(True, "", "")]


def _stated(vehicle: Vehicle, key: str) -> float | None:
    """Return a figure in SI, None if the file does not state it."""
    figure = vehicle.figures().get(key)
    return None if figure is None else figure.value


def _over_size(
    key: str, of_size: Callable[[Vehicle], float]
) -> Callable[[Vehicle], float | None]:
    """Return a function: a stated figure over a size of the vehicle."""

    def ratio(vehicle: Vehicle) -> float | None:
        found = _stated(vehicle, key)
        return None if found is None else found / of_size(vehicle)

    return ratio


def _weight(vehicle: Vehicle) -> float:
    return vehicle.body.mass_kg.value * G


def _length(vehicle: Vehicle) -> float:
    return vehicle.wheelbase


def _speed(vehicle: Vehicle) -> float:
    """Return the speed sqrt(g l) that goes with a car's size: Froude's."""
    return sqrt(G * vehicle.wheelbase)


def _stiffness(front: bool) -> Callable[[Vehicle], float | None]:
    """Return a function: cornering stiffness of an axle over the load that it bears."""

    def ratio(vehicle: Vehicle) -> float | None:
        body, tyres = vehicle.body, vehicle.tyres
        C, arm = (
            (tyres.front_cornering_stiffness_n_per_rad, body.cg_to_rear_axle_m)
            if front
            else (tyres.rear_cornering_stiffness_n_per_rad, body.cg_to_front_axle_m)
        )
        load = _weight(vehicle) * arm.value / vehicle.wheelbase
        return 2 * C.value / load

    return ratio


def _cell_voltage(vehicle: Vehicle) -> float | None:
    series = CELLS.match(vehicle.battery.configuration)
    volts = open_circuit_voltage(vehicle)
    if series is None or volts is None or int(series[1]) == 0:
        return None
    return volts / int(series[1])


def _voltage_key(vehicle: Vehicle) -> str:
    there = vehicle.battery.open_circuit_voltage_v is not None
    return f"battery.{'open_circuit' if there else 'nominal'}_voltage_v"


def _specific_energy(vehicle: Vehicle) -> float | None:
    """Return Wh of battery per kg of vehicle, and no unit but these."""
    energy = vehicle.battery_energy
    return energy and energy / J_PER_WH / vehicle.body.mass_kg.value


def _short_circuit(vehicle: Vehicle) -> float | None:
    """Return u_0/(R Q): charges an hour that a short circuit would draw."""
    charge, ohm = vehicle.battery.capacity_ah, _stated(vehicle, _BATTERY_R)
    volts = open_circuit_voltage(vehicle)
    if charge is None or volts is None or not ohm:
        return None
    return volts / (ohm * charge.value)


def _idle_speed(vehicle: Vehicle) -> float:
    """Return the speed on the road at the battery's voltage over sqrt(g l)."""
    return speed_by_linkage(vehicle) * vehicle.lever / _speed(vehicle)


def _two_constants(vehicle: Vehicle) -> float:
    """Return the speed by the motor's KV over that by its flux linkage."""
    return speed_by_constant(vehicle) / speed_by_linkage(vehicle)


def _rotor(vehicle: Vehicle) -> float | None:
    """Return the mass that the motor's inertia adds, over the vehicle's."""
    inertia = _stated(vehicle, "effects.rotor_inertia.inertia_kgm2")
    if inertia is None:
        return None
    added = float(reflected_mass(inertia, 1 / vehicle.lever))
    return added / vehicle.body.mass_kg.value


def _damping(vehicle: Vehicle) -> float | None:
    """Return the rate B n²/m at which damping slows a vehicle, times sqrt(l/g)."""
    B = _stated(vehicle, "effects.drivetrain_damping.damping_nms_per_rad")
    if B is None:
        return None
    slows = B * vehicle.rad_per_m**2 / vehicle.body.mass_kg.value
    return slows * vehicle.wheelbase / _speed(vehicle)


def _stall(vehicle: Vehicle) -> float:
    """Return the force at the wheels that voltage and resistance allow at standstill.

    Over the weight.
    """
    motor = envelope_of(vehicle)
    torque = motor.voltage_speed * motor.voltage_slope
    return torque / vehicle.lever / _weight(vehicle)


def _most_torque(vehicle: Vehicle) -> float:
    """Return the force at the wheels of the most torque that is stated, over weight."""
    return envelope_of(vehicle).torque.value / vehicle.lever / _weight(vehicle)


def _torque_key(vehicle: Vehicle) -> str:
    return envelope_of(vehicle).torque.by


_BATTERY_R = "effects.battery_resistance.resistance_ohm"
_MOTOR_R = "effects.copper_loss.phase_resistance_ohm"
_PER_TYRE = "N/rad of ONE tyre; N per degree times 57.3"

RATIOS = (
    Ratio(
        "tyres.front_cornering_stiffness_n_per_rad",
        "2 C_F over the front axle's load",
        _stiffness(front=True),
        1.0,
        60.0,
        _PER_TYRE,
    ),
    Ratio(
        "tyres.rear_cornering_stiffness_n_per_rad",
        "2 C_R over the rear axle's load",
        _stiffness(front=False),
        1.0,
        60.0,
        _PER_TYRE,
    ),
    Ratio(
        "body.track_width_m",
        "track over wheelbase",
        _over_size("body.track_width_m", _length),
        0.2,
        2.0,
        "in m",
    ),
    Ratio(
        "body.cg_height_m",
        "height of the CG over wheelbase",
        _over_size("body.cg_height_m", _length),
        0.03,
        1.0,
        "in m, above the ground",
    ),
    Ratio(
        "battery.nominal_voltage_v",
        "voltage of a cell [V]",
        _cell_voltage,
        1.0,
        4.5,
        "volts of the whole pack, and cells in series: 11.1 of 3S",
        _voltage_key,
    ),
    Ratio(
        "battery.capacity_ah",
        "battery energy by mass of the vehicle [Wh/kg]",
        _specific_energy,
        0.3,
        DENSEST,
        "ampere-hours: 5200 mAh is 5.2",
    ),
    Ratio(
        _BATTERY_R,
        "charges an hour of a short circuit",
        _short_circuit,
        2.0,
        inf,
        "ohms of the whole pack: 30 mOhm is 0.03",
    ),
    Ratio(
        "motor.flux_linkage_wb",
        "speed at the battery's voltage, over sqrt(g l)",
        _idle_speed,
        0.5,
        100.0,
        "peak flux linkage of one phase, in Wb: 0.887 mWb is 0.887e-3",
    ),
    Ratio(
        "motor.velocity_constant_rpm_per_v",
        "no-load speed by it over that by the flux linkage",
        _two_constants,
        0.65,
        1.5,
        "K_V is 30/pi/(sqrt(3) poles/2 flux_linkage): one of the three is off",
    ),
    Ratio(
        "effects.rotor_inertia.inertia_kgm2",
        "mass that it adds over the vehicle's",
        _rotor,
        0.0,
        1.0,
        "kg m² at the motor's shaft; 1 g cm² is 1e-7 kg m²",
    ),
    Ratio(
        "effects.drivetrain_damping.damping_nms_per_rad",
        "rate at which it slows the vehicle, times sqrt(l/g)",
        _damping,
        0.0,
        0.3,
        "N m s/rad at the motor's shaft; 1 mN m/krpm is 9.55e-6",
    ),
    Ratio(
        _MOTOR_R,
        "force at standstill, by voltage over resistance, over the weight",
        _stall,
        0.1,
        inf,
        "ohms of one phase: 20 mOhm is 0.02",
    ),
    Ratio(
        "motor.max_torque_nm",
        "force at the wheels by the least limit of torque or current, over the weight",
        _most_torque,
        0.03,
        20.0,
        "N m at the motor's shaft, before the gear; A of the motor's phase",
        _torque_key,
    ),
    Ratio(
        "effects.aerodynamic_drag.drag_area_m2",
        "drag area over the square of the wheelbase",
        _over_size(
            "effects.aerodynamic_drag.drag_area_m2", lambda car: car.wheelbase**2
        ),
        0.0,
        1.0,
        "m² at the vehicle's own size: a tenth the size, a hundredth the area",
    ),
    Ratio(
        "effects.road_load.a_n",
        "force over the weight",
        _over_size("effects.road_load.a_n", _weight),
        -0.02,
        0.3,
        "newtons; 1 lbf is 4.448 N",
    ),
    Ratio(
        "effects.auxiliary_load.power_w",
        "power over m g sqrt(g l)",
        _over_size(
            "effects.auxiliary_load.power_w", lambda car: _weight(car) * _speed(car)
        ),
        0.0,
        5.0,
        "watts: 0.5 kW is 500",
    ),
)
