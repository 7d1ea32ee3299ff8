"""A first draft of a column map, by the words and units of a header."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import isclose
from typing import NamedTuple

from rcc_sim.errors import InputError
from rcc_sim.readers import parquet
from rcc_sim.readers.column_map import CLOCK, DATE, UNITS
from rcc_sim.readers.csv_table import text_table
from rcc_sim.readers.own import WRITTEN, is_named_so
from rcc_sim.readers.words import is_date
from rcc_sim.source import Source
from rcc_sim.units import unit_of


class Meaning(NamedTuple):
    """What a column is if its name has one word of each group, and none of `never`."""

    column: str
    unit: str
    words: tuple[str, ...]
    never: str = ""


OF_BATTERY = "motor phase aux heater heating ac cell min max limit low 12v"

MEANINGS = (
    Meaning("time_s", "s", ("time timestamp clock date datetime zeit",)),
    Meaning(
        "speed_ref_mps",
        "m/s",
        ("speed velocity geschwindigkeit", "ref target set cmd desired soll"),
    ),
    Meaning("motor_speed_erpm", "erpm", ("erpm",), "ref target set cmd"),
    Meaning(
        "motor_speed_radps",
        "rad/s",
        ("motor engine rotor rpm", "speed rpm drehzahl"),
        "fan soll",
    ),
    Meaning(
        "speed_mps",
        "m/s",
        ("speed velocity vel geschwindigkeit",),
        "motor wheel fan wind",
    ),
    Meaning("motor_torque_nm", "N m", ("torque drehmoment",), "brake wheel target"),
    Meaning(
        "motor_current_a",
        "A",
        ("motor", "current strom amps amp amperes"),
        "target limit max",
    ),
    Meaning("battery_voltage_v", "V", ("voltage spannung volt volts",), OF_BATTERY),
    Meaning("battery_current_a", "A", ("current strom amps amp amperes",), OF_BATTERY),
    Meaning(
        "battery_power_w",
        "W",
        ("battery hv pack batterie", "power leistung"),
        "max limit",
    ),
    Meaning("aux_power_w", "W", ("aux heater heating hvac ac aircon", "power")),
    Meaning("headwind_mps", "m/s", ("headwind",)),
    Meaning("state_of_charge_percent", "%", ("soc charge",), "current power"),
    Meaning("elevation_m", "m", ("elevation altitude height alt",)),
    Meaning("slope", "1", ("slope gradient grade steigung",)),
    Meaning(
        "accel_x_mps2",
        "m/s²",
        ("acceleration accel acc beschleunigung", "x longitudinal long längs"),
    ),
    Meaning(
        "accel_y_mps2",
        "m/s²",
        ("acceleration accel acc beschleunigung", "y lateral lat quer"),
    ),
    Meaning("yaw_rate_radps", "rad/s", ("yaw gyro gier", "rate z")),
    Meaning("steer_cmd_rad", "rad", ("steer steering lenk",), "wheel torque"),
    Meaning("throttle", "1", ("throttle",)),
    Meaning("motor_temperature_degc", "°C", ("motor", "temperature temp")),
    Meaning("ambient_temperature_degc", "°C", ("ambient outside", "temperature temp")),
)
"""The first that fits a name; in a map, the first column that fits a meaning."""

SHORTENED = {
    "spd": "speed", "trq": "torque", "tq": "torque", "thr": "throttle",
    "bat": "battery", "batt": "battery", "cur": "current", "curr": "current",
    "gyr": "gyro", "accelerometer": "accel", "baro": "elevation",
}  # fmt: skip
"""Words that loggers shorten -> what they stand for."""

CAPITAL = re.compile(r"(?<=[a-z])(?=[A-Z][a-z]|[XYZ](?![A-Za-z]))")
"""Where a word, or an axis, begins within a name: "WheelSpd", "GyrZ_dps"."""

COMPOUND = re.compile(
    r"(motor|batterie|akku|lenk|soll|ist|gier|längs|quer|heiz)(?=[a-zäöü]{4})"
)
"""First parts of German words, which are written together."""

PATHS = {
    ("drive", "speed"): "speed_ref_mps",
    ("cmd_vel", "linear", "x"): "speed_ref_mps",
    ("drive", "steering_angle"): "steer_cmd_rad",
    ("twist", "linear", "x"): "speed_mps",
    ("angular_velocity", "z"): "yaw_rate_radps",
    ("linear_acceleration", "x"): "accel_x_mps2",
    ("linear_acceleration", "y"): "accel_y_mps2",
    ("position", "x"): "x_m",
    ("position", "y"): "y_m",
    ("state", "speed"): "motor_speed_erpm",
}
"""How the path of a ROS message's field ends -> our column: a command by Ackermann or
Twist, an odometry, an IMU, a VESC, whose speed is in electrical turns a minute."""

SHORT = {
    name: column
    for column, names in {
        "time_s": "t ts secs seconds elapsed stamp",
        "speed_mps": "v vx v_x vel_x speed_x v_ist",
        "speed_ref_mps": "v_ref v_cmd v_des v_soll",
        "battery_voltage_v": "v_in vin v_bat vbat v_batt vbatt u_bat ubat u_batt",
        "battery_current_a": "i_in iin i_bat ibat i_batt ibatt",
        "motor_current_a": "i_motor i_mot imotor",
        "duty_cycle": "duty duty_cycle dutycycle duty_now duty_cycle_now",
        "yaw_rate_radps": "gz gyroz gyro_z wz w_z omega_z yawrate",
        "accel_x_mps2": "ax a_x accx",
        "accel_y_mps2": "ay a_y accy",
        "steer_cmd_rad": "delta delta_cmd steer_cmd",
    }.items()
    for name in names.split()
}
"""Whole names that loggers abbreviate -> our column."""

LAST = {"gz", "wz", "ax", "ay", "vx"}
"""Those of them that a name may end in: "imu_ax"."""

IMPLIED = {
    "m/s": "speed", "A": "current", "V": "voltage", "W": "power", "N m": "torque",
    "rad/s": "rate", "°C": "temperature",
}  # fmt: skip
"""Unit -> the word that it stands for in a name without: "bat_mA", "target_kmh"."""

QUANTITIES = {
    word
    for meaning in MEANINGS
    for group in meaning.words
    if {*IMPLIED.values()} & {*group.split()}
    for word in group.split()
}
"""The words of which a name has one, else its unit stands for it."""

STEERING_RATIO = 16.0
"""Turns of a car's steering wheel over those of its road wheels, 12 to 20 being usual.
[1]"""

SPELT = WRITTEN | {
    "mps": "m/s", "sec": "s", "seconds": "s",
    "µs": "us", "nm": "N m", "n·m": "N m", "m/s2": "m/s^2", "m/s²": "m/s^2",
    "°": "deg", "degrees": "deg", "°/s": "deg/s", "dps": "deg/s", "1/min": "rpm",
    "°c": "degC", "c": "degC", "volts": "V", "amps": "A",
}  # fmt: skip
"""How units are written in headers -> how a map names them."""

SPEEDS = ("rpm", "kmh", "kph", "mph")
"""Units that may stand for the quantity in a name, and before what it is of."""

UNIT = re.compile(r"[\[(]\s*([^\])]+?)\s*[\])]\s*$")


class Entry(NamedTuple):
    """One line of a draft: a column of ours, and what it is made of."""

    column: str
    name: str
    unit: str = ""
    factor: float = 1.0
    because: str = ""

    def toml(self) -> str:
        """Return the line as TOML, with why it is not by its name alone."""
        parts = [f"from = {json.dumps(self.name, ensure_ascii=False)}"]
        size = abs(self.factor)
        parts += [f'unit = "{self.unit}"'] if self.unit else []
        parts += [f"factor = {size:.6g}"] if size != 1.0 else []
        parts += ["sign = -1"] if self.factor < 0 else []
        why = f"  # {self.because}" if self.because else ""
        return f"{self.column} = {{ {', '.join(parts)} }}{why}"

    def times(self, factor: float, because: str) -> Entry:
        """Return the entry with another factor, told as a unit where one has it."""
        size = abs(factor)
        ours = unit_of(self.column)
        fit = (
            u
            for u, (f, to) in UNITS.items()
            if to == ours and isclose(f, size, rel_tol=1e-4)
        )
        unit = next(fit, "") if not self.unit and size != 1.0 else ""
        because = "; ".join(x for x in (self.because, because) if x)
        if unit:
            factor /= size
        return self._replace(
            unit=unit or self.unit, factor=self.factor * factor, because=because
        )


@dataclass(frozen=True)
class Draft:
    """A column map to look through: what was understood of a header, and what not."""

    separator: str
    entries: tuple[Entry, ...]
    left: tuple[str, ...]

    def toml(self) -> str:
        """Return it as a column map, what was not understood as a comment."""
        how = ["[map]", f"separator = {json.dumps(self.separator)}", ""]
        lines = [
            "# a draft by names, units and what the channels say of each other: look",
            "# through it; a power that is positive when charging takes sign = -1",
            *(how if self.separator else []),
            "[columns]",
            *(entry.toml() for entry in self.entries),
            *(["", "# not understood:"] if self.left else []),
            *(f"#   {name}" for name in self.left),
        ]
        return "\n".join(lines) + "\n"


def drafted(source: Source) -> Draft:
    """Return a column map by the names and units of a header.

    In a file of our own (it has ``time_s``) a name that is ours means what it says.

    Raises
    ------
    InputError
        If the file is no table.
    """
    header, row, separator = _header(source)
    first = dict(zip(header, row, strict=False))
    names = [name for name in header if name]
    ours = [n for n in names if is_named_so(n)] if "time_s" in names else []
    found = {name: Entry(name, name) for name in ours}
    left = []
    for name in names:
        if name in found:
            continue
        if is_steering_wheel(name) and "steer_cmd_rad" not in found:
            found["steer_cmd_rad"] = at_the_steering_wheel(name)
            continue
        meaning = meaning_of(name)
        if meaning is None or meaning.column in found:
            left.append(name)
            continue
        written = time_unit(first.get(name, "")) if meaning.column == "time_s" else ""
        unit = written or unit_in(name)
        if meaning.unit == "%" or (unit and not written and UNITS[unit][0] == 1.0):
            unit = ""
        found[meaning.column] = Entry(meaning.column, name, unit)
    if "speed_mps" not in found:
        wheel = next((name for name in left if is_wheel_speed(name)), "")
        if wheel:
            left.remove(wheel)
            unit = unit_in(wheel)
            found["speed_mps"] = Entry(
                "speed_mps", wheel, unit, because="of a wheel: it slips, or locks"
            )
    return Draft(separator, tuple(found.values()), tuple(left))


def _header(source: Source) -> tuple[Sequence[str], Sequence[str], str]:
    """Return the names of a table's columns, its first row as words, its separator."""
    if parquet.sniff(source):
        return *parquet.header(source), ""
    table = text_table(source)
    if table is None:
        raise InputError(f"{source.name}: not a table, of CSV or Parquet")
    return table.names, table.first, table.separator


def meaning_of(name: str) -> Meaning | None:
    """Return what a column of that name is likeliest."""
    parts = tuple(re.split(r"[/.]+", name.strip().lower()))
    path = next((c for end, c in PATHS.items() if parts[-len(end) :] == end), "")
    if path:
        return Meaning(path, unit_of(path), ())
    whole = COMPOUND.sub(r"\1 ", CAPITAL.sub(" ", UNIT.sub("", name)).lower())
    words = {SHORTENED.get(w, w) for w in re.findall(r"[a-zäöüß0-9]+", whole)}
    unit = UNITS.get(unit_in(name), (1.0, ""))[1]
    joined = _joined(UNIT.sub("", name))
    short = SHORT.get(joined)
    if not short and unit and not UNIT.search(name):  # "Vbat mV", "ay_g"
        short = SHORT.get(_joined(re.sub(r"[_\s][^_\s]+\s*$", "", name)))
    last = joined.rpartition("_")[2]
    if not short and last in LAST:
        short = SHORT[last]
    if short:
        fits = unit in ("", unit_of(short))
        return Meaning(short, unit_of(short), ()) if fits else None
    found = fitting(words, unit)
    if found is None and unit in IMPLIED and not words & QUANTITIES:
        found = fitting(words | {IMPLIED[unit]}, unit)
    return found


def is_steering_wheel(name: str) -> bool:
    """Tell whether a name is that of the angle of a car's steering wheel.

    >>> is_steering_wheel("SWA [deg]"), is_steering_wheel("Steering Wheel Torque [Nm]")
    (True, False)
    """
    if UNITS.get(unit_in(name), (1.0, "rad"))[1] != "rad":
        return False
    whole = CAPITAL.sub(" ", UNIT.sub("", name)).lower()
    words = {SHORTENED.get(w, w) for w in re.findall(r"[a-zäöüß]+", whole)}
    if words & {"torque", "moment", "drehmoment", "speed", "rate", "velocity"}:
        return False
    turned = {"steer", "steering", "hand"} & words and "wheel" in words
    return bool(turned or words & {"swa", "hwa", "lenkrad", "lenkradwinkel"})


def at_the_steering_wheel(name: str) -> Entry:
    """Return the entry of a column that is told in the driver's hands."""
    unit = "" if unit_in(name) == "rad" else unit_in(name)
    why = f"of the steering wheel: take the car's own ratio for {STEERING_RATIO:g}"
    return Entry("steer_cmd_rad", name, unit, 1 / STEERING_RATIO, why)


def is_wheel_speed(name: str) -> bool:
    """Tell whether a name is that of a wheel's speed over the ground."""
    rest = re.sub("wheel", "", name, flags=re.IGNORECASE)
    if rest == name or UNITS.get(unit_in(name), (1.0, ""))[1] != "m/s":
        return False
    meaning = meaning_of(rest.strip(" _"))
    return meaning is not None and meaning.column == "speed_mps"


def fitting(words: set[str], unit: str) -> Meaning | None:
    """Return the first meaning that fits a name's words, and its unit if it has one."""
    for meaning in MEANINGS:
        fits = all(words & set(group.split()) for group in meaning.words)
        if not fits or words & set(meaning.never.split()):
            continue
        if not unit or unit == meaning.unit or (unit, meaning.unit) == ("1", "%"):
            return meaning
    return None


def _joined(name: str) -> str:
    """Return the words of a name as ``SHORT`` has them."""
    return "_".join(re.findall(r"[a-z0-9]+", name.lower()))


def unit_in(name: str) -> str:
    """Return the unit that a name ends in, as a map names it; empty if none is known.

    A unit of speed may begin it.

    >>> unit_in("Vehicle Speed (km/h)"), unit_in("Torque [Nm]"), unit_in("rpm_motor")
    ('km/h', 'N m', 'rpm')
    """
    at = UNIT.search(name)
    if at and at.group(1).startswith(("+", "-")):  # a sign: "Pack A (+chg)"
        name, at = name[: at.start()], None
    parts = re.split(r"[_\s]", name.strip())
    written = at.group(1) if at else parts[-1]
    if not at and parts[0].lower() in SPEEDS:
        written = parts[0]
    spelt = SPELT.get(written.lower(), written)
    return spelt if spelt in UNITS else ""


def time_unit(word: str) -> str:
    """Return the unit of a time that is written as words; empty of a number."""
    if is_date(word):
        return DATE
    return CLOCK if re.match(r"\d+:\d+:\d", word.strip()) else ""
