"""What a battery gives beside what its motor's current asks of it.

A rough road pushes the motor, and the battery gives what that asks for: judged each for
itself, the same push would count twice. Where the motor's current i_q was logged, the
battery is judged by what is left of it,

    i - i_model - (K_t ω + 3 R i_q) / u (i_q - i_q,model),

which tells of what lies between the two.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import moving_mean, rows_in, sensor_noise
from rcc_sim.definitions.kernel import motor_torque_constant
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.residuals.terminals import CURRENT, POWER, VOLTAGE
from rcc_sim.trace import Trace

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

MOTOR, SPEED = "motor_current_a", "motor_speed_radps"

KNOWN = 0.5
"""Share of the battery's rows at which the motor's current must be known: the others
are left out, or else the battery is judged by itself."""

PUSHED = 0.3
"""Time over which the motor's current is a mean. A rough road pushes for longer, and
the mean of some rows has little noise. [s]"""


@dataclass(frozen=True)
class BesideMotor:
    """How the battery's track is judged beside the motor's.

    Parameters
    ----------
    motor, battery : int
        Their places among the channels.
    drawn : ndarray, shape (n,)
        What the battery gives more per ampere of the motor's current.
    rows : int
        Over which that is a mean.
    known : ndarray of bool, shape (n,)
        Where the motor's current is known, so that the battery can be judged.
    """

    motor: int
    battery: int
    drawn: Array
    rows: int
    known: Mask

    def __call__(self, tracks: Sequence[Array]) -> list[Array]:
        """Return tracks, of measured less predicted or of a change of it, so judged."""
        told = list(tracks)
        asked = self.drawn * moving_mean(tracks[self.motor], self.rows)
        told[self.battery] = tracks[self.battery] - asked
        return told


def beside_motor(
    channels: Sequence[str], log: Trace, nominal: Mapping[str, Array], vehicle: Vehicle
) -> BesideMotor | None:
    """Return how a log's battery is judged beside its motor; None if it is not.

    A current that is mostly its sensor's noise tells as much less. What pushes the
    motor shows in the battery alone where its current was lost: as another noise.
    """
    battery = next((c for c in (CURRENT, POWER) if c in channels), None)
    if MOTOR not in channels or battery is None:
        return None
    rows = rows_in(log["time_s"], PUSHED)
    known_at = moving_mean(np.isfinite(log[MOTOR]).astype(float), rows) > 0.5 / rows
    if known_at[np.isfinite(log[battery])].mean() < KNOWN:
        return None
    left = log[MOTOR] - nominal[MOTOR]
    size = float(np.nanvar(moving_mean(left, rows)))
    noise = sensor_noise(left) ** 2 / rows
    known = max(1 - noise / size, 0.0) if size > 0 else 0.0
    drawn = known * drawn_by_motor(vehicle, nominal, battery)
    places = channels.index(MOTOR), channels.index(battery)
    return BesideMotor(*places, drawn, rows, known_at)


def drawn_by_motor(vehicle: Vehicle, nominal: Mapping[str, Array], of: str) -> Array:
    """Return what the battery gives more, per ampere of the motor's current.

    In power it is K_t ω + 3 R i_q, the derivative of K_t ω i_q + 3/2 R i_q²; nil where
    the motor is not known. [W/A], or [A/A] of a current
    """
    K_t = motor_torque_constant(vehicle)
    if K_t is None:
        return np.zeros(len(nominal["time_s"]))
    ohm = vehicle.figures().get("effects.copper_loss.phase_resistance_ohm")
    R = ohm.value if ohm else 0.0
    power = K_t * nominal[SPEED] + 3 * R * nominal[MOTOR]
    drawn: Array = np.nan_to_num(power / nominal[VOLTAGE] if of == CURRENT else power)
    return drawn
