"""Reports for tests: a drive of the car that rolls, told by a car that does not."""

from __future__ import annotations

import numpy as np

from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.prices import Prices
from rcc_sim.diagnose.signatures import Signature, Signatures
from rcc_sim.report.findings import Report, Span
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

COLUMNS = ("speed_mps", "motor_current_a", "battery_power_w", "yaw_rate_radps")

NASTY = "<script>alert(1)</script>"


def drive(duration: float) -> Cycle:
    """Return a drive of stops and goes."""
    corners = np.array([0.0, 1, 4, 8, 10, 14, 16, 18])
    speeds = np.array([0.0, 0, 4, 4, 6, 6, 0, 0])
    n = int(duration // 18)
    time = np.concatenate([corners[:-1] + 18.0 * k for k in range(n)] + [[18.0 * n]])
    speed = np.concatenate([speeds[:-1]] * n + [[0.0]])
    return Cycle("stop and go", time, speed)


def spans(time: np.ndarray) -> tuple[Span, ...]:
    """Return the kinds of driving of `drive`, repeated."""
    found = []
    for start in np.arange(0.0, time[-1], 18.0):
        for a, b, name in (
            (0, 1, "standstill"),
            (1, 4, "acceleration"),
            (4, 8, "cruise"),
            (8, 10, "acceleration"),
            (10, 14, "cruise"),
            (14, 16, "deceleration"),
            (16, 18, "standstill"),
        ):
            found.append(Span(start + a, start + b, name))
    return tuple(found)


def diagnosis_report(duration: float = 72.0, name: str = "drive.csv") -> Report:
    """Return what a diagnosis hands over, whole; figures of §5 that belong together."""
    rng = np.random.default_rng(1)
    car, cycle = load_vehicle("rcc"), drive(duration)
    rolls = car.changed(effects={"rolling_resistance": {"coefficient": 0.02}})
    here = load_vehicle("rcc").changed(
        effects={"rolling_resistance": {"coefficient": 0.0196}}
    )
    steer = (
        np.arange(0.0, duration, 0.02),
        0.02 * np.sin(np.arange(0.0, duration, 0.02)),
    )
    runs = [
        simulate(v, cycle, steer=steer, output_rate=100.0).trace
        for v in (rolls, car, here)
    ]
    true, before, after = runs
    noise = {"speed_mps": 0.02, "motor_current_a": 0.4, "battery_power_w": 3.0}
    log = {c: true[c] + rng.normal(0.0, noise.get(c, 0.01), len(true)) for c in COLUMNS}
    log["battery_power_w"][len(true) // 2] = 400.0  # a spike that must be seen
    wh = [float(np.trapezoid(t["battery_power_w"], t["time_s"])) / 3600 for t in runs]
    measured, simulated, mended = wh
    gap = measured - simulated
    return Report(
        title=f"Diagnosis of {name} with vehicle rcc",
        diagnosis={
            "schema": "rccsim.diagnosis/1",
            "log": name,
            "vehicle": "rcc",
            "mode": "commanded",
            "status": "explained",
            "where": {
                "energy": {
                    "measured_wh": measured,
                    "simulated_wh": simulated,
                    "gap_wh": gap,
                    "gap_percent": 100 * gap / measured,
                },
                "channels": [
                    {"channel": c, "rmse": 6.1, "bias": 3.0, "noise": 0.8, "score": s}
                    for c, s in zip(COLUMNS, (0.98, 0.61, 0.41, 0.97), strict=True)
                ],
                "regimes": [
                    {"regime": r, "time_s": t, "gap_wh": s * gap, "share": s}
                    for r, t, s in (
                        ("cruise", 32.0, 0.71),
                        ("acceleration", 20.0, 0.33),
                        ("deceleration", 8.0, -0.04),
                        ("standstill", 12.0, 0.0),
                    )
                ],
                "stages": [
                    {"stage": "mechanical", "gap_wh": 0.92 * gap, "share": 0.92},
                    {"stage": "electrical", "gap_wh": 0.08 * gap, "share": 0.08},
                ],
                "windows": [
                    {
                        "start_s": 22.0,
                        "end_s": 32.0,
                        "channel": "battery_power_w",
                        "share": 0.4,
                    }
                ],
            },
            "causes": [
                {
                    "effect": "rolling_resistance",
                    "probability": 0.97,
                    "parameters": {
                        "coefficient": {"value": 0.0196, "low": 0.019, "high": 0.0203}
                    },
                    "indistinguishable_from": ["drivetrain_friction"],
                    "explains": 0.93,
                }
            ],
            "ranking": [
                {"effect": e, "probability": p, "explains": x}
                for e, p, x in (
                    ("rolling_resistance", 0.97, 0.93),
                    ("drivetrain_friction", 0.97, 0.93),
                    ("unknown", 0.02, None),
                    ("road_grade", 0.004, 0.71),
                    ("payload", 0.001, 0.22),
                )
            ],
            "shrink": {
                "held_out": True,
                "before": 1.0,
                "after": 0.08,
                "explained": 0.92,
                "low": 0.89,
                "high": 0.94,
                "energy_gap_percent_before": 100 * gap / measured,
                "energy_gap_percent_after": 0.7,
            },
            "unexplained": {"fraction": 0.05, "windows": []},
            "next_experiment": [
                {
                    "do": "coast down from 5 m/s in both directions",
                    "separates": ["rolling_resistance", "road_grade"],
                    "expected_nats": {
                        "least": 25.0,
                        "pairs": [
                            {"a": "rolling_resistance", "b": "road_grade", "nats": 25.0}
                        ],
                    },
                }
            ],
        },
        measured=Trace({"time_s": true["time_s"], **log}, name=name),
        before={c: before[c] for c in COLUMNS},
        after={c: after[c] for c in COLUMNS},
        regimes=spans(true["time_s"]),
        prices=Prices(
            {"rolling_resistance": mended - simulated}, 0.0, measured - mended
        ),
        signatures=Signatures(
            {"motor_current_a": log["motor_current_a"] - before["motor_current_a"]},
            (
                Signature(
                    "rolling_resistance",
                    {"coefficient": 0.0196},
                    {
                        "motor_current_a": after["motor_current_a"]
                        - before["motor_current_a"]
                    },
                ),
                Signature(
                    "road_grade",
                    {"slope": 0.01},
                    {"motor_current_a": np.full(len(true), 3.0)},
                ),
            ),
        ),
        log_check=(
            Finding(
                "spike",
                "battery_power_w",
                "One row stands 400 W above its neighbours.",
                where="36 s",
                sure=0.99,
                action="left out",
                severity="warning",
            ),
        ),
        vehicle_diff=(
            "--- rcc.toml\n+++ rcc_mended.toml\n@@ -40,3 +40,6 @@\n"
            " [effects.drivetrain_damping]\n damping_nms_per_rad = 1.17e-5\n"
            "+\n+[effects.rolling_resistance]\n"
            "+coefficient = { value = 0.0196, low = 0.019, high = 0.0203, "
            'source = "derived: '
            f'{name}" }}\n'
        ),
        run={
            "command": f"rccsim diagnose '{name}' --vehicle rcc --html report.html",
            "seed": 0,
            "inputs": [{"name": name, "sha256": "0" * 64}],
            "versions": {"rccsim": "0.1.0", "python": "3.12.1"},
        },
    )
