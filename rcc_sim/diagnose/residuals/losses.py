"""By which rows and powers a drive tells what its motor loses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import moving_mean, rows_in
from rcc_sim.diagnose.residuals.shapes import TORQUE

if TYPE_CHECKING:
    from rcc_sim.diagnose.residuals.problem import Problem

Array = NDArray[np.float64]

EVENED = 1.0
"""Time over which a motor's power by a logged speed is a mean. [s]"""


def told(problem: Problem, signal: Array) -> Array:
    """Return what an efficiency changes in a channel, as far as rows tell it.

    Evened; and where the motor's torque keeps its sign: a mean of what drives and what
    coasts is a small torque, and no small power.
    """
    if not problem.drive.imposed:
        return signal
    torque = torque_of(problem)
    change = np.abs(np.diff(torque, prepend=0.0, append=0.0))
    keeps = np.abs(torque) > np.maximum(change[1:], change[:-1])
    return evened(problem, signal) * keeps


def load_of(problem: Problem) -> Array:
    """Size of that torque: what goes by its sign is a mass, or a smoothed motion."""
    return np.abs(torque_of(problem))


def torque_of(problem: Problem) -> Array:
    """Torque [N m] of the nominal model's motor, evened."""
    return evened(problem, np.nan_to_num(problem.nominal[TORQUE]))


def evened(problem: Problem, x: Array) -> Array:
    """What a model says of its motor, without what a logged speed's noise adds.

    Where that drives a power high or low, none is measured: the power would look as if
    it were lost. By commands nothing is added.
    """
    if not problem.drive.imposed:
        return x
    return moving_mean(x, rows_in(problem.log["time_s"], EVENED))
