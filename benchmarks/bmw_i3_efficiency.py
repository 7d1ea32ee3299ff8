"""Fit vehicles/bmw_i3_efficiency.csv to the TU Munich logs; judge it on other trips.

The loss L of motor and inverter is a polynomial of |torque| and speed; efficiency is
P/(P + L). Each trip has a load of its own beside the heater and air conditioning that
were logged. Every figure is a mean over 10 s.

    python benchmarks/bmw_i3_efficiency.py FOLDER [MAP.csv]
"""

import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.optimize import least_squares

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.vehicle import load_vehicle

FITTED = [
    "A01",
    "A02",
    "A23",
    "A24",
    "A25",
    "A26",
    "A27",
    "A28",
    "B03",
    "B05",
    "B06",
    "B11",
]
JUDGED = ["B16", "B17", "B18", "B19", "B22", "B33"]
TORQUE = np.array([0, 5, 10, 20, 40, 60, 90, 130, 180, 250.0])  # N m
SPEED = np.array([0, 50, *range(100, 1101, 100)], dtype=float)  # rad/s
LEAST = 1.0, 10.0  # N m, rad/s; below, the efficiency stays
ROWS, SOFT = 100, 300.0  # rows of a mean; W beyond which it counts less
START = [100, 900, 0, 2900, -600, -8900, 7000, 2600]  # W


def loss(c, torque, speed):
    """Loss [W] at |torque| [N m] and speed [rad/s]."""
    w, t = speed / 1000, torque / 100
    return c @ np.stack([w, w**2, w**3, t, t**2, w * t, w**2 * t, t**2 * w])


def efficiency(c):
    """Efficiency over the grid of torque and speed."""
    grid = np.maximum(TORQUE, LEAST[0]), np.maximum(SPEED, LEAST[1])
    T, W = np.meshgrid(*grid, indexing="ij")
    lost = np.maximum(loss(c, T.ravel(), W.ravel()).reshape(T.shape), 0)
    return np.clip(T * W / (T * W + lost), 0.05, 1.0)


def read(folder, trip, car):
    """Shaft power, torque and speed [W, N m, rad/s], and power lost or unknown [W]."""
    log = open_log(folder / f"Trip{trip}.csv.gz", car).log
    ratio = car.drivetrain.gear_ratio.value / car.tyres.radius_m.value
    torque, speed = log["motor_torque_nm"], log["speed_mps"] * ratio
    power = log["battery_voltage_v"] * log["battery_current_a"] - log["aux_power_w"]
    known = np.isfinite(torque * speed * power)
    torque, speed, power = torque[known], speed[known], power[known]
    return torque * speed, np.abs(torque), speed, power - torque * speed


def left(c, trip):
    """What a map leaves of a trip: the load that was not logged, in means. [W]"""
    P, torque, speed, lost = trip
    look_up = RegularGridInterpolator((TORQUE, SPEED), efficiency(c))
    eta = look_up((torque.clip(max=TORQUE[-1]), speed.clip(0, SPEED[-1])))
    rest = lost - np.where(P >= 0, P / eta - P, P * eta - P)
    return rest[: len(rest) // ROWS * ROWS].reshape(-1, ROWS).mean(1)


def main():
    """Fit, judge and write."""
    folder, car = Path(sys.argv[1]), load_vehicle("bmw_i3")
    trips = {t: read(folder, t, car) for t in FITTED + JUDGED}
    n = len(START)

    def off(p):
        rests = [left(p[:n], trips[t]) for t in FITTED]
        return np.concatenate([r - x for r, x in zip(rests, p[n:], strict=True)]) / SOFT

    start = np.array(START + [500] * len(FITTED), dtype=float)
    scale = np.array([500] * n + [100] * len(FITTED), dtype=float)
    found = least_squares(
        off, start, loss="soft_l1", x_scale=scale, diff_step=1e-3, max_nfev=30
    ).x
    c, load = found[:n], found[n:]
    print(f"load beside what was logged {load.mean():.0f} W, sd {load.std():.0f} W")
    for name, of in (("fitted", FITTED), ("judged", JUDGED)):
        rests = [left(c, trips[t]) for t in of]
        each = "  ".join(f"{t} {r.mean():.0f}" for t, r in zip(of, rests, strict=True))
        print(f"{name}: {np.mean([r.std() for r in rests]):.0f} W left; load {each}")
    if len(sys.argv) > 2:
        eta = efficiency(c)
        rows = [
            f"{t:g},{w:g},{eta[i, j]:.3f}"
            for i, t in enumerate(TORQUE)
            for j, w in enumerate(SPEED)
        ]
        head = "torque_nm,speed_radps,efficiency"
        Path(sys.argv[2]).write_text("\n".join([head, *rows, ""]))


if __name__ == "__main__":
    main()
