"""A driven second at 1 kHz beside other people's vehicle models; FASTSim 2 on a cycle.

    python -m benchmarks.peers

CommonRoad's single track (commonroad-vehicle-models) is what the F1TENTH gym compiles
with numba and integrates from Python, step by step; no package of the gym is in the
registry, so that its place is taken by CommonRoad's own function, compiled likewise.
Each peer integrates seven states; ours adds motor, controller, path follower, energy
ledger and trace. FASTSim 2 cannot live beside FASTSim 3 and gets an environment of its
own for the run, by pip. What cannot be had is said and left out.
"""

from __future__ import annotations

import importlib.util
import statistics
import subprocess
import sys
import tempfile
import time
from collections import namedtuple
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.run import LaneChanges, simulate

DT = 1e-3  # s; everyone's step
STEPS = 5000  # of a peer, timed
ROUNDS = 7
PARAMETERS = {  # what CommonRoad's single track reads
    "tire": ("p_dy1", "p_ky1"),
    "steering": ("min", "max", "v_min", "v_max"),
    "longitudinal": ("v_min", "v_max", "v_switch", "a_max"),
    "": ("a", "b", "h_s", "m", "I_z"),
}
FASTSIM_2 = "fastsim>=2.1.5,<3"
RUN_FASTSIM_2 = """
import statistics, time
import fastsim
car = fastsim.vehicle.Vehicle.from_vehdb(17).to_rust()
cycle = fastsim.cycle.Cycle.from_file("udds").to_rust()
took = []
for _ in range({rounds}):
    drive = fastsim.simdrive.RustSimDrive(cycle, car)
    start = time.perf_counter()
    drive.sim_drive()
    took.append(time.perf_counter() - start)
print(fastsim.__version__, car.veh_pt_type, statistics.median(took))
"""

Rates = Callable[[NDArray[np.float64], NDArray[np.float64]], Any]


def main() -> None:
    """Print a line per peer."""
    ours = our_step()
    print(
        f"rccsim, a step of 1 ms with lane changes, all included: {1e6 * ours:.2f} µs"
    )
    against_commonroad(ours)
    against_fastsim_2()


def our_step() -> float:
    """Return what a step of the commanded run with lane changes takes. [s]"""
    car, udds = load_vehicle("rcc"), parse_cycle("udds")
    slow = Cycle("udds at 0.416", udds.time_s, 0.416 * udds.speed_mps)
    lanes = LaneChanges(20.0)
    simulate(car, slow, lanes=lanes)  # compiles
    return median(lambda: simulate(car, slow, lanes=lanes)) / (slow.duration / DT)


def against_commonroad(ours: float) -> None:
    """Print what its single track takes, in plain Python and compiled."""
    if importlib.util.find_spec("vehiclemodels") is None:
        print("CommonRoad, F1TENTH: left out, commonroad-vehicle-models not installed")
        return
    from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st
    from vehiclemodels.vehicle_parameters import setup_vehicle_parameters

    p = setup_vehicle_parameters(vehicle_id=2)

    def plain(x: NDArray[np.float64], u: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.array(vehicle_dynamics_st(x, u, p))

    gym = "as the F1TENTH gym has it, compiled (no gym in the registry)"
    for rates, how in (
        (plain, "as it comes"),
        (compiled_rates(vehicle_dynamics_st, p), gym),
    ):
        for name, step in (("Euler", euler), ("RK4", runge_kutta)):
            took = peer_step(rates, step)
            print(
                f"CommonRoad's single track, {how}, {name}: {1e6 * took:.2f} µs:"
                f" ratio {ours / took:.4f}"
            )


def compiled_rates(function: Callable[..., Any], p: Any) -> Rates:
    """Return CommonRoad's function in machine code, its parameters built in."""
    import numba

    parts = {
        part: namedtuple(part, keys)(
            *(float(getattr(getattr(p, part), k)) for k in keys)
        )
        for part, keys in PARAMETERS.items()
        if part
    }
    own = {key: float(getattr(p, key)) for key in PARAMETERS[""]}
    record = namedtuple("record", (*parts, *own))(**parts, **own)
    inner = compiled(function)

    @numba.njit
    def rates(x: Any, u: Any) -> Any:
        return np.array(inner(x, u, record))

    return rates


def compiled(function: Callable[..., Any]) -> Any:
    """Return a function compiled with all the functions that it calls by name."""
    import numba

    names = dict(function.__globals__)
    for name in function.__code__.co_names:
        if isinstance(names.get(name), FunctionType):
            names[name] = compiled(names[name])
    return numba.njit(FunctionType(function.__code__, names, function.__name__))


def euler(f: Rates, x: NDArray[np.float64], u: NDArray[np.float64]) -> Any:
    """Return the state a step later."""
    return x + DT * f(x, u)


def runge_kutta(f: Rates, x: NDArray[np.float64], u: NDArray[np.float64]) -> Any:
    """Return the state a step later, by the classic rule of fourth order."""
    k_1 = f(x, u)
    k_2 = f(x + 0.5 * DT * k_1, u)
    k_3 = f(x + 0.5 * DT * k_2, u)
    k_4 = f(x + DT * k_3, u)
    return x + DT / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)


def peer_step(f: Rates, step: Callable[..., Any]) -> float:
    """Return what a step takes from Python, steering gently at 10 m/s. [s]"""
    inputs = [np.array([0.05 * np.cos(6.0 * k * DT), 0.0]) for k in range(STEPS)]
    start = np.array([0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0])

    def drive() -> None:
        x = start
        for u in inputs:
            x = step(f, x, u)
        if not np.isfinite(x).all():
            sys.exit("CommonRoad's single track diverged")

    drive()
    return median(drive) / STEPS


def against_fastsim_2() -> None:
    """Time FASTSim 2's compiled class on UDDS, from an environment of its own."""
    truck, udds = load_vehicle("r1t_epa"), parse_cycle("udds")
    simulate(truck, udds, imposed=True)
    ours = median(lambda: simulate(truck, udds, imposed=True))
    with tempfile.TemporaryDirectory() as folder:
        python = str(Path(folder) / "bin" / "python")
        script = RUN_FASTSIM_2.format(rounds=ROUNDS)
        for what, command in (
            ("make an environment", [sys.executable, "-m", "venv", folder]),
            ("install it", [python, "-m", "pip", "install", "--quiet",
                            "--disable-pip-version-check", FASTSIM_2]),
            ("run it", [python, "-c", script]),
        ):  # fmt: skip
            done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
            if done.returncode != 0:
                reason = (done.stderr or done.stdout).strip().splitlines() or ["?"]
                print(f"FASTSim 2: left out, could not {what}: {reason[-1]}")
                return
    version, kind, took = done.stdout.split()[-3:]
    print(
        f"imposed UDDS, 1 Hz: {1e3 * ours:.2f} ms against FASTSim {version} ({kind},"
        f" its compiled class) {1e3 * float(took):.1f} ms: ratio"
        f" {ours / float(took):.3f}"
    )


def median(run: Callable[[], object]) -> float:
    """Return the median time of a call. [s]"""
    took = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        run()
        took.append(time.perf_counter() - start)
    return statistics.median(took)


if __name__ == "__main__":
    main()
