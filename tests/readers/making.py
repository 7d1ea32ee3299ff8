"""Logs of every format, made here, of one drive whose numbers are known."""

from __future__ import annotations

import sqlite3

import numpy as np

TIME = np.arange(200) / 50
SPEED = 1.5 + np.sin(TIME)
STEER = 0.1 * np.cos(TIME)
VOLTAGE = 12 - 0.1 * SPEED
CURRENT = 3 * SPEED
ERPM = 5000 * SPEED
YAW_RATE = 0.3 * np.sin(2 * TIME)
ACCEL = np.cos(TIME)
G = 9.80665

VESC_HEADER = (
    "ms_today;input_voltage;temp_motor;current_motor;current_in;d_axis_current;"
    "q_axis_current;erpm;duty_cycle;fault_code;d_axis_voltage;q_axis_voltage;"
    "speed_meters_per_sec;ms_today_imu;accX;accY;accZ;gyroX;gyroY;gyroZ;"
    "gnss_posTime;gnss_alt;"
)


def vesc_rows(start_ms=1000, imu=True, gnss=False):
    """Rows of a VESC Tool log as dicts of the header's names."""
    rows = []
    for k in range(len(TIME)):
        stamp = (start_ms + round(1000 * TIME[k])) % 86_400_000
        rows.append(
            {
                "ms_today": stamp,
                "input_voltage": VOLTAGE[k],
                "temp_motor": -80,
                "current_motor": 2 * CURRENT[k],
                "current_in": CURRENT[k],
                "d_axis_current": 0.1,
                "q_axis_current": 2 * CURRENT[k],
                "erpm": ERPM[k],
                "duty_cycle": 0.4,
                "fault_code": 0,
                "d_axis_voltage": -0.2,
                "q_axis_voltage": 5,
                "speed_meters_per_sec": SPEED[k],
                "ms_today_imu": stamp if imu else -1,
                "accX": ACCEL[k] / G if imu else 0,
                "accY": 0,
                "accZ": 1 if imu else 0,
                "gyroX": 0,
                "gyroY": 0,
                "gyroZ": np.degrees(YAW_RATE[k]) if imu else 0,
                "gnss_posTime": stamp if gnss else -1,
                "gnss_alt": 7.5 if gnss else 0,
            }
        )
    return rows


def write_vesc(path, **options):
    """Write a VESC Tool log: every line ends in a separator."""
    names = VESC_HEADER.rstrip(";").split(";")
    rows = vesc_rows(**options)
    lines = ["".join(f"{row[name]};" for name in names) for row in rows]
    path.write_text("\n".join([VESC_HEADER, *lines]) + "\n")
    return path


def stores():
    """Message types with the new VescState, and with the old one."""
    from rcc_sim.readers.ros_messages import typestores

    return typestores()


def header(store, stamp):
    """A header of this stamp [ns]; ROS 1 wants a number of its own."""
    time = store.types["builtin_interfaces/msg/Time"](
        sec=stamp // 10**9, nanosec=stamp % 10**9
    )
    return store.types["std_msgs/msg/Header"](stamp=time, frame_id="")


def filled(store, kind, **values):
    """A message with these fields, by dots, and all others 0."""
    from rosbags.interfaces import Nodetype

    fields = {}
    for name, (node, about) in store.fielddefs[kind][1]:
        inner = {
            key.removeprefix(f"{name}."): value
            for key, value in values.items()
            if key.startswith(f"{name}.")
        }
        if name in values:
            fields[name] = values[name]
        elif node == Nodetype.NAME:
            fields[name] = filled(store, about, **inner)
        elif node == Nodetype.ARRAY:
            fields[name] = np.zeros(about[1])
        else:
            fields[name] = "" if about[0] == "string" else 0
    return store.types[kind](**fields)


def f1tenth_messages(store, start_ns, imu_in_g=True):
    """Topic, type, stamp and message of the drive, as an F1TENTH car logs it."""
    acc, gyro = (G, np.pi / 180) if imu_in_g else (1.0, 1.0)
    up = G / acc
    for k in range(len(TIME)):
        stamp = start_ns + round(TIME[k] * 1e9)
        head = header(store, stamp)
        yield (
            "/sensors/core",
            "vesc_msgs/msg/VescStateStamped",
            stamp,
            filled(
                store,
                "vesc_msgs/msg/VescStateStamped",
                header=head,
                **{
                    "state.speed": ERPM[k],
                    "state.voltage_input": VOLTAGE[k],
                    "state.current_input": CURRENT[k],
                    "state.current_motor": 2 * CURRENT[k],
                },
            ),
        )
        odometry = {"twist.twist.linear.x": SPEED[k], "pose.pose.orientation.w": 1.0}
        yield (
            "/odom",
            "nav_msgs/msg/Odometry",
            stamp,
            filled(store, "nav_msgs/msg/Odometry", header=head, **odometry),
        )
        yield (
            "/sensors/imu/raw",
            "sensor_msgs/msg/Imu",
            stamp,
            filled(
                store,
                "sensor_msgs/msg/Imu",
                header=head,
                **{
                    "linear_acceleration.x": ACCEL[k] / acc / 10,
                    "linear_acceleration.z": up,
                    "angular_velocity.z": YAW_RATE[k] / gyro,
                },
            ),
        )
        if k % 5 == 0:  # commands come at another rate
            yield (
                "/drive",
                "ackermann_msgs/msg/AckermannDriveStamped",
                stamp + 1_000_000,
                filled(
                    store,
                    "ackermann_msgs/msg/AckermannDriveStamped",
                    header=header(store, stamp + 1_000_000),
                    **{"drive.speed": SPEED[k], "drive.steering_angle": STEER[k]},
                ),
            )


def write_bag(folder, store, storage="MCAP", start_ns=0, extra=(), **options):
    """Write a ROS 2 bag of the drive."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    plugin = StoragePlugin[storage]
    with Writer(folder, version=8, storage_plugin=plugin) as bag:
        links = {}
        messages = [*f1tenth_messages(store, start_ns, **options), *extra]
        for topic, kind, stamp, message in messages:
            if topic not in links:
                links[topic] = bag.add_connection(topic, kind, typestore=store)
            bag.write(links[topic], stamp, store.serialize_cdr(message, kind))
    return folder


def without_definitions(folder):
    """Take the message definitions out of an sqlite3 bag, as rosbag2 writes it."""
    (file,) = folder.glob("*.db3")
    with sqlite3.connect(file) as database:
        database.execute("DELETE FROM message_definitions")
    database.close()
    return folder


def convert_bag(source, target, storage="sqlite3"):
    """Convert a bag by rosbags' own converter."""
    from rosbags.convert import convert

    convert(
        [source],
        target,
        dst_storage=storage,
        dst_version=8,
        compress=None,
        compress_mode="file",
        default_typestore=None,
        typestore=None,
        exclude_topics=[],
        include_topics=[],
        exclude_msgtypes=[],
        include_msgtypes=[],
    )
    return target
