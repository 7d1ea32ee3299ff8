"""What a log knows at its rows, as the loops over them read it: by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


class Commands(NamedTuple):
    """What was asked of the vehicle, and what acted on it, each of shape (n,).

    Parameters
    ----------
    ref : ndarray
        Speed reference. [m/s]
    steer : ndarray
        Steering angle that was commanded. [rad]
    throttle : ndarray
        Throttle. [1]
    aux : ndarray
        Auxiliary power. [W]
    wind : ndarray
        Headwind. [m/s]
    """

    ref: Array
    steer: Array
    throttle: Array
    aux: Array
    wind: Array


class Measured(NamedTuple):
    """What was measured of the vehicle, each of shape (n,); NaN where not known.

    Parameters
    ----------
    speed : ndarray
        Speed. [m/s]
    current : ndarray
        Current of the motor. [A]
    yaw_rate : ndarray
        Yaw rate. [rad/s]
    torque : ndarray
        Torque of the motor's shaft. [N m]
    accel : ndarray
        Acceleration that bends the speed between the rows. [m/s²]
    """

    speed: Array
    current: Array
    yaw_rate: Array
    torque: Array
    accel: Array
