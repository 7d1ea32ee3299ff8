"""A car in the hands of one loop that sends a command, logs a row, and sleeps."""

import numpy as np

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.simulate.run import simulate

TICK = 0.001
STIFF = {"controller.proportional_gain_as_per_rad": 1.5}
"""Of a car that has the speed it is told within a tenth of a second."""

NOISE = {
    "speed_mps": 0.005,
    "accel_x_mps2": 0.1,
    "motor_current_a": 0.15,
    "battery_current_a": 0.05,
}


def wanted(time):
    """Return the speed that is wanted at some times. [m/s]"""
    swings = 2.0 + 1.1 * np.sin(0.5 * time) + 0.5 * np.sin(1.3 * time)
    return swings * np.clip((time - 1.0) / 2.0, 0.0, 1.0)


def rows(true, row, jitter, seconds, seed):
    """Return the rows of a drive: a cycle sent row by row, each as late as it comes.

    What moves is a sample; currents are means since the row before, as of a VESC.
    """
    rng = np.random.default_rng(seed)
    n = round(seconds / row)
    spans = row * np.clip(1 + jitter * rng.standard_normal(n), 0.3, 3.0)
    time = np.concatenate([[0.0], np.cumsum(spans)])
    sent = wanted(row * np.arange(n + 1))
    tick = np.arange(0.0, time[-1], TICK)
    held = Cycle("c", tick, sent[np.searchsorted(time, tick + 1e-9, "right") - 1])
    car = true.changed(effects={"reference_sampling": {"period_s": TICK}})
    seen = simulate(car, held, output_rate=1 / TICK).trace
    ends, log = seen["time_s"], {"time_s": time, "speed_ref_mps": sent}
    for name, sd in NOISE.items():
        now = np.interp(time, ends, seen[name])
        if name.endswith("_a"):
            sums = np.concatenate([[0.0], np.cumsum(seen[name]) * TICK])
            flowed = np.diff(np.interp(time, [ends[0] - TICK, *ends], sums))
            now[1:] = flowed / np.diff(time)
        log[name] = now + sd * rng.standard_normal(n + 1)
    return log
