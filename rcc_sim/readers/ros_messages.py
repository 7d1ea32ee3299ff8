"""Message definitions that bags may lack: VESC and Ackermann."""

from __future__ import annotations

from functools import cache
from typing import Any

STAMPED = """
std_msgs/Header header
vesc_msgs/VescState state
"""

OLD_STATE = """
float64 voltage_input
float64 temperature_pcb
float64 current_motor
float64 current_input
float64 speed
float64 duty_cycle
float64 charge_drawn
float64 charge_regen
float64 energy_drawn
float64 energy_regen
float64 displacement
float64 distance_traveled
int32 fault_code
"""
"""VescState of the MIT racecar, MuSHR and older F1TENTH cars."""

NEW_STATE = """
float64 temp_fet
float64 temp_motor
float64 current_motor
float64 current_input
float64 avg_id
float64 avg_iq
float64 duty_cycle
float64 speed
float64 voltage_input
float64 charge_drawn
float64 charge_regen
float64 energy_drawn
float64 energy_regen
int32 displacement
int32 distance_traveled
int32 fault_code
float64 pid_pos_now
int32 controller_id
float64 ntc_temp_mos1
float64 ntc_temp_mos2
float64 ntc_temp_mos3
float64 avg_vd
float64 avg_vq
"""
"""VescState of F1TENTH's driver for ROS 2."""

OTHERS = {
    "vesc_msgs/msg/VescStateStamped": STAMPED,
    "vesc_msgs/msg/VescImu": """
geometry_msgs/Vector3 ypr
geometry_msgs/Vector3 linear_acceleration
geometry_msgs/Vector3 angular_velocity
geometry_msgs/Vector3 compass
geometry_msgs/Quaternion orientation
""",
    "vesc_msgs/msg/VescImuStamped": """
std_msgs/Header header
vesc_msgs/VescImu imu
""",
    "ackermann_msgs/msg/AckermannDrive": """
float32 steering_angle
float32 steering_angle_velocity
float32 speed
float32 acceleration
float32 jerk
""",
    "ackermann_msgs/msg/AckermannDriveStamped": """
std_msgs/Header header
ackermann_msgs/AckermannDrive drive
""",
}


@cache
def typestores() -> tuple[Any, Any]:
    """Message types of ROS 2 with the new VescState, and with the old one."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    found = []
    for state in (NEW_STATE, OLD_STATE):
        store = get_typestore(Stores.ROS2_HUMBLE)
        types: dict[str, Any] = {}
        for name, text in {**OTHERS, "vesc_msgs/msg/VescState": state}.items():
            types |= get_types_from_msg(text, name)
        store.register(types)
        found.append(store)
    return found[0], found[1]
