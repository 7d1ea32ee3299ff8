"""What a car plays: speed and steering commands, as a bag or as CSV."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rcc_sim.errors import InputError
from rcc_sim.files import atomic
from rcc_sim.readers.car import Car, ratios
from rcc_sim.readers.extras import library
from rcc_sim.readers.log import Array
from rcc_sim.readers.ros_messages import typestores
from rcc_sim.trace import Trace, write_trace

FORMATS = ("mcap", "csv")
DRIVE = ("/drive", "ackermann_msgs/msg/AckermannDriveStamped")
MOTOR = ("/commands/motor/speed", "std_msgs/msg/Float64")


def commands(
    time: ArrayLike, speed: ArrayLike, steer: ArrayLike | None, vehicle: Car
) -> Trace:
    r"""Commands of a drive in the units that the car takes.

    .. math:: \mathrm{ERPM} = \frac{60}{2\pi} \frac{N_p}{2} \frac{N_d}{r_w} v

    Parameters
    ----------
    time, speed : array_like, shape (n,)
        When, and the speed from then on. [s], [m/s]
    steer : array_like, shape (n,), or None
        Road-wheel angle, positive to the left; None drives straight. [rad]
    vehicle : Car
        Whose gear, wheel and poles count.

    Returns
    -------
    trace : Trace
        ``time_s, speed_ref_mps, steer_cmd_rad, motor_speed_ref_erpm``.

    Raises
    ------
    InputError
        If the vehicle does not state them, or the arrays are not finite, alike in
        length, and increasing in time.
    """
    t, v = _array("time", time), _array("speed", speed)
    angle = np.zeros(len(t)) if steer is None else _array("steer", steer)
    if not len(t) == len(v) == len(angle) or len(t) == 0:
        raise InputError(
            f"commands: time, speed and steer should be alike in length: "
            f"{len(t)}, {len(v)}, {len(angle)}"
        )
    if t[0] < 0 or (np.diff(t) <= 0).any():
        raise InputError("commands: time should start at 0 or later, and increase")
    found = ratios(vehicle)
    return Trace(
        {
            "time_s": t,
            "speed_ref_mps": v,
            "steer_cmd_rad": angle,
            "motor_speed_ref_erpm": v * found.radps_per_mps * found.erpm_per_radps,
        },
        name="commands",
    )


def write_commands(
    path: str | Path,
    time: ArrayLike,
    speed: ArrayLike,
    steer: ArrayLike | None,
    vehicle: Car,
    format: str = "mcap",
) -> None:
    """Write what a car plays, whole or not at all.

    ``mcap`` is one file that `ros2 bag play` reads: ``/drive`` (AckermannDriveStamped,
    whose numbers are 32 bit) and ``/commands/motor/speed`` (ERPM), a message of each a
    row. A car takes one of the two: choose with `ros2 bag play FILE --topics /drive`.

    Parameters
    ----------
    path : str or Path
        File to write.
    time, speed, steer, vehicle
        As in `commands`.
    format : str
        "mcap" or "csv".

    Raises
    ------
    InputError
        As in `commands`; if the format is unknown, its library is missing, or the file
        cannot be written.
    """
    if format not in FORMATS:
        raise InputError(f"format: should be one of {', '.join(FORMATS)}: {format!r}")
    played = commands(time, speed, steer, vehicle)
    with atomic(Path(path), "wb") as file:
        if format == "csv":
            write_trace(played, file)
            return
        with tempfile.TemporaryDirectory() as folder:
            bag = Path(folder, "bag")
            _write_bag(played, bag, str(path))
            file.write((bag / "bag.mcap").read_bytes())


def _write_bag(played: Trace, folder: Path, where: str) -> None:
    bags = library("rosbags.rosbag2", "ros", where)
    store = typestores()[0]
    stamps = np.round(played["time_s"] * 1e9).astype(np.int64).tolist()
    bag = bags.Writer(folder, version=8, storage_plugin=bags.StoragePlugin.MCAP)
    with bag:
        drive = bag.add_connection(*DRIVE, typestore=store)
        motor = bag.add_connection(*MOTOR, typestore=store)
        rows = zip(
            stamps,
            played["speed_ref_mps"].tolist(),
            played["steer_cmd_rad"].tolist(),
            played["motor_speed_ref_erpm"].tolist(),
            strict=True,
        )
        for stamp, v, angle, erpm in rows:
            ackermann = _drive_message(store, stamp, v, angle)
            bag.write(drive, stamp, store.serialize_cdr(ackermann, DRIVE[1]))
            turn = store.types[MOTOR[1]](data=erpm)
            bag.write(motor, stamp, store.serialize_cdr(turn, MOTOR[1]))


def _drive_message(store: Any, stamp: int, v: float, angle: float) -> Any:
    types = store.types
    sec, nanosec = divmod(stamp, 1_000_000_000)
    header = types["std_msgs/msg/Header"](
        stamp=types["builtin_interfaces/msg/Time"](sec=sec, nanosec=nanosec),
        frame_id="base_link",
    )
    drive = types["ackermann_msgs/msg/AckermannDrive"](
        steering_angle=angle,
        steering_angle_velocity=0.0,
        speed=v,
        acceleration=0.0,
        jerk=0.0,
    )
    return types[DRIVE[1]](header=header, drive=drive)


def _array(name: str, values: ArrayLike) -> Array:
    array = np.atleast_1d(np.asarray(values, dtype=float))
    if not np.isfinite(array).all():
        row = int((~np.isfinite(array)).argmax()) + 1
        raise InputError(f"commands: {name}, row {row}: should be a finite number")
    return array
