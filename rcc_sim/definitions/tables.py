"""The tables of a vehicle file, their keys, and the sizes that are believable."""

from __future__ import annotations

from math import degrees, inf
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from rcc_sim.definitions.figure import Figure


def _within(low: float, high: float, *, zero: bool = False) -> AfterValidator:
    """Refuse a figure outside (low, high), or below zero, or zero unless allowed.

    One whose ``low`` is below zero may be.
    """

    def check(figure: Figure) -> Figure:
        ends = (figure.value, figure.low, figure.high)
        for number in (end for end in ends if end is not None):
            if low >= 0 and (number < 0 or (number == 0 and not zero)):
                rule = "at least 0" if zero else "greater than 0"
                raise ValueError(f"should be {rule}: {number:g}")
            if number != 0 and not low <= number <= high:
                raise ValueError(f"should lie between {low:g} and {high:g}: {number:g}")
        return figure

    return AfterValidator(check)


Mass = Annotated[Figure, _within(0.02, 2e5)]
Inertia = Annotated[Figure, _within(1e-6, 1e7)]
Length = Annotated[Figure, _within(0.002, 20.0)]
Stiffness = Annotated[Figure, _within(0.5, 1e7)]
Positive = Annotated[Figure, _within(1e-15, 1e15)]
NotNegative = Annotated[Figure, _within(1e-15, inf, zero=True)]


STEER = 0.01, 1.5
"""Between which the largest angle of road wheels lies. [rad]"""


class Table(BaseModel):
    """A table of the file: frozen, and without keys that nobody reads."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    def figures(self) -> dict[str, Figure]:
        """Key -> figure, of the keys that are stated."""
        return {k: v for k, v in self if isinstance(v, Figure)}


class Heading(Table):
    """[vehicle]: what it is called and where its figures come from."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", max_length=80)
    title: str = ""
    source: str = ""
    extends: str = ""
    notes: str = ""
    mended_without: tuple[str, ...] = ()


class Body(Table):
    """[body]: mass, where it sits, how it turns."""

    mass_kg: Mass
    yaw_inertia_kgm2: Inertia
    cg_to_front_axle_m: Length
    cg_to_rear_axle_m: Length
    cg_height_m: Length | None = None
    track_width_m: Length | None = None


class Tyres(Table):
    """[tyres]: per TYRE, as in the paper; an axle has two."""

    radius_m: Length
    front_cornering_stiffness_n_per_rad: Stiffness
    rear_cornering_stiffness_n_per_rad: Stiffness
    friction_coefficient: Annotated[Figure, _within(0.02, 5.0)] | None = None
    type: str = ""


class Drivetrain(Table):
    """[drivetrain]: from the motor shaft to the wheels."""

    gear_ratio: Annotated[Figure, _within(0.1, 200.0)]
    driven_axle: Literal["front", "rear", "all"] = "all"


class Motor(Table):
    """[motor]: constants of the machine, and its envelope."""

    poles: Annotated[int, Field(ge=2, le=200, multiple_of=2)] | None = None
    flux_linkage_wb: Positive | None = None
    average_inductance_h: Positive | None = None
    inductance_difference_h: NotNegative | None = None
    velocity_constant_rpm_per_v: Positive | None = None
    rated_power_w: Positive | None = None
    rated_torque_nm: Positive | None = None
    rated_voltage_v: Positive | None = None
    rated_speed_radps: Positive | None = None
    max_speed_radps: Positive | None = None
    max_torque_nm: Positive | None = None
    max_power_w: Positive | None = None


class Battery(Table):
    """[battery]."""

    chemistry: str = ""
    configuration: str = ""
    nominal_voltage_v: Positive | None = None
    open_circuit_voltage_v: Positive | None = None
    capacity_ah: Positive | None = None
    max_discharge_rate_per_h: Positive | None = None


class Controller(Table):
    """[controller]: who decides the motor's torque, and within which limits."""

    mode: Literal["speed", "torque", "throttle"]
    proportional_gain_as_per_rad: NotNegative | None = None
    integral_gain_a_per_rad: NotNegative | None = None
    max_current_a: Positive | None = None
    peak_current_a: Positive | None = None
    loop_rate_hz: Annotated[Figure, _within(1.0, 1e5)] | None = None
    max_torque_nm: Positive | None = None
    min_input_voltage_v: Positive | None = None
    max_input_voltage_v: Positive | None = None
    max_electrical_speed_radps: Positive | None = None
    bec_voltage_v: Positive | None = None
    bec_current_a: Positive | None = None
    max_steer_rad: Annotated[Figure, _within(*STEER)] | None = None
    steering_command: list[float] | None = None
    steering_angle_rad: list[float] | None = None
    driver_time_constant_s: Positive | None = None
    force_throttle: list[float] | None = None
    force_speed_mps: list[float] | None = None
    force_n: list[list[float]] | None = None
    force_scale: Positive | None = None


class Sensor(Table):
    """[sensors.COLUMN]: what the sensor adds, in the column's unit."""

    noise_sd: NotNegative | None = None
    bias_sd: NotNegative | None = None
    scale_sd: NotNegative | None = None
    resolution: NotNegative | None = None
    latency_s: Annotated[Figure, _within(-2.0, 2.0)] | None = None


ADVICE = {
    "body.mass_kg": "mass ready to drive, in kg",
    "body.yaw_inertia_kgm2": "yaw inertia about the centre of mass; "
    "measure it with `rccsim inertia`",
    "body.cg_to_front_axle_m": "metres, from the centre of mass; "
    "find it with `rccsim cg`",
    "body.cg_to_rear_axle_m": "metres, from the centre of mass; "
    "find it with `rccsim cg`",
    "tyres.radius_m": "rolling radius in metres",
    "tyres.front_cornering_stiffness_n_per_rad": "N/rad of ONE tyre (an axle has two)",
    "tyres.rear_cornering_stiffness_n_per_rad": "N/rad of ONE tyre (an axle has two)",
    "tyres.friction_coefficient": "for the groups of pi; what limits the tyres' force "
    "is effects.tyre_saturation",
    "drivetrain.gear_ratio": "motor turns per wheel turn",
    "motor.poles": "number of poles, not of pole pairs: an even number",
    "controller.mode": 'one of "speed", "torque", "throttle"',
    "controller.steering_command": "rising commands as a log's `steering` holds them, "
    "-1 to 1 say",
    "controller.steering_angle_rad": "angle of the road wheels at each of them, "
    "positive left; straight between, held at the ends",
    "controller.driver_time_constant_s": "time in which the driver of a torque-driven "
    "vehicle makes up for a wrong speed; that in which it answers its steering where "
    "none is stated",
    "controller.force_throttle": "rising throttles, -1 to 1, one a row of force_n",
    "controller.force_speed_mps": "rising speeds, one a column of force_n",
    "controller.force_n": "force at the wheels by throttle and speed, for "
    '`mode = "throttle"`; bilinear between, held at the edges',
    "controller.force_scale": "what force_n is multiplied by; its sd is what a charge "
    "that is not logged does",
    "sensors.noise_sd": "noise of a reading; of elevation_m, how far heights may be "
    "off, slowly too",
    "sensors.bias_sd": "sd of an offset that stays over a drive; a fifth of the noise "
    "where none is stated, by diagnose and gap",
    "sensors.resolution": "step between two readings; counts as noise where noise_sd "
    "is stated",
    "sensors.latency_s": "how late it reads, one for all columns of a sensor; the same "
    "as that sensor's figure of effects.sensor_delay, which counts where both stand; "
    "of a battery less than 0 where it was asked after the speed",
    "sensors.scale_sd": "share by which it may read too much or too little: of "
    "motor_torque_nm, 0.03 where none is stated, of elevation_m, 0.1, of yaw rate and "
    "accelerations, 0.015; of no other (a current's is effects.current_sensor_scale)",
    "vehicle.name": "letters, digits, _ . and - only",
}
"""Key -> what to say when its value is refused."""

LENGTHS = {
    "body.cg_to_front_axle_m",
    "body.cg_to_rear_axle_m",
    "body.cg_height_m",
    "body.track_width_m",
    "tyres.radius_m",
}

OTHER_UNITS = {
    "_ohm": (1e3, "mOhm"),
    "_rad": (degrees(1.0), "degrees"),
    "coefficient": (100.0, "%"),
    "efficiency": (100.0, "%"),
}
"""End of a key -> how much larger numbers of another usual unit are, and its name."""


def advice(key: str, value: Any) -> str:
    """Return the likely mend of a refused value, or an empty text."""
    number = value.get("value") if isinstance(value, dict) else value
    if key in LENGTHS and isinstance(number, int | float) and number > 20:
        return f"metres are meant; {number:g} mm would be {number / 1000:g}"
    if key == "controller.max_steer_rad" and isinstance(number, int | float):
        return in_other_unit(key, number, *STEER)
    return ADVICE.get(key, "")


def in_other_unit(key: str, number: float, low: float, high: float) -> str:
    """Return what a number that is out of bounds would be, were its unit another.

    >>> in_other_unit("resistance_ohm", 30.0, 0.0, 10.0)
    '30 mOhm would be 0.03'
    """
    for end, (per, unit) in OTHER_UNITS.items():
        if key.endswith(end) and number > high and low <= number / per <= high:
            return f"{number:g} {unit} would be {number / per:.3g}"
    return ""
