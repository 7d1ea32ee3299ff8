"""The compiled kernel against the same model as a plain C loop, and against FASTSim.

    python benchmarks/kernel.py

Runs both sides in turn and prints medians and ratios; the C loop needs gcc, FASTSim
`pip install "rccsim[bench]"`. What is missing is said and left out.
"""

from __future__ import annotations

import importlib.util
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from math import inf
from pathlib import Path

from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.kernel import kernel_params
from rcc_sim.definitions.vehicle import Vehicle, load_vehicle
from rcc_sim.simulate.run import LaneChanges, Run, simulate

HERE = Path(__file__).parent
ROUNDS = 7


def main() -> None:
    """Print the table."""
    car, udds = load_vehicle("rcc"), parse_cycle("udds")
    slow = Cycle("udds at 0.416", udds.time_s, 0.416 * udds.speed_mps)
    truck = load_vehicle("r1t_epa")
    for label, lanes in (("straight", None), ("lane changes", LaneChanges(20.0))):
        against_c(label, car, slow, lanes)
    show("imposed UDDS, 1 Hz, in process", lambda: simulate(truck, udds, imposed=True))
    against_fastsim(truck, udds)
    whole_process("imposed UDDS", "r1t_epa", "--imposed")
    whole_process("commanded UDDS, 1 kHz", "rcc")


def against_c(
    label: str, car: Vehicle, cycle: Cycle, lanes: LaneChanges | None
) -> None:
    """Time the commanded run against the C loop; check that they agree."""
    if shutil.which("gcc") is None:
        print("C loop: left out, no gcc")
        return
    with tempfile.TemporaryDirectory() as folder:
        arguments = c_arguments(Path(folder), car, cycle, lanes)
        run = simulate(car, cycle, lanes=lanes)  # compiles
        ours, theirs = [], []
        for _ in range(ROUNDS):
            start = time.perf_counter()
            run = simulate(car, cycle, lanes=lanes)
            ours.append(time.perf_counter() - start)
            out = subprocess.run(arguments, capture_output=True, text=True, check=True)
            theirs.append(float(out.stdout.split()[0]))
    distance, energy = (float(part) for part in out.stdout.split()[1:3])
    agree(run, distance, energy)
    mine, c = statistics.median(ours), statistics.median(theirs)
    print(
        f"commanded UDDS, 1369 s at 1 kHz, {label}: {1e3 * mine:.0f} ms"
        f" (trace included) against C {1e3 * c:.0f} ms: ratio {mine / c:.2f}"
    )


def agree(run: Run, distance: float, energy: float) -> None:
    """Stop if the C loop drove something else."""
    ours = float(run.trace["distance_m"][-1])
    if abs(ours / distance - 1) > 1e-9 or abs(run.battery_energy / energy - 1) > 1e-9:
        sys.exit(
            f"the C loop differs: {ours} m, {run.battery_energy} J against "
            f"{distance} m, {energy} J"
        )


def c_arguments(
    folder: Path, car: Vehicle, cycle: Cycle, lanes: LaneChanges | None
) -> list[str]:
    """Compile the C loop and write its input; return the command."""
    p = kernel_params(car, commanded=True)
    if lanes is not None:
        p["lanes"] = lanes.params(car)
    K_t = p["motor"]["K_t"]
    regen = p["regeneration_limit"]
    values = {
        "K_t": K_t, **p["body"], **p["tyre"], **p["drive"], **p["battery"],
        **{k: p["control"][k] for k in ("K_p", "K_i", "i_max", "delta_max")},
        "i_min": min(p["control"]["i_max"], regen["max_current_a"]),
        "T": p["control"]["T_loop"], "follow": p["lanes"]["steer"] == 2.0,
        "every": p["lanes"]["every"], "width": p["lanes"]["width"],
        "length": p["lanes"]["length"],
        "B": p["drivetrain_damping"]["damping_nms_per_rad"],
        "J": p["rotor_inertia"]["inertia_kgm2"],
        "R": p["copper_loss"]["phase_resistance_ohm"],
        "dead": p["speed_dead_zone"]["threshold_radps"],
        "hold": p["reference_sampling"]["period_s"],
        "C_rr": p["rolling_resistance"]["coefficient"],
        "CdA": p["aerodynamic_drag"]["drag_area_m2"],
        "rho": p["aerodynamic_drag"]["air_density_kg_per_m3"],
        "T_C": p["drivetrain_friction"]["torque_nm"],
        "T_h": p["iron_loss"]["hysteresis_torque_nm"],
        "k_e": p["iron_loss"]["eddy_nms_per_rad"],
        "eta_g": p["gear_loss"]["efficiency"], "eta_m": p["motor_efficiency"]["scale"],
        "aux": p["auxiliary_load"]["power_w"],
        "R_i": p["battery_resistance"]["resistance_ohm"],
        "A_n": p["road_load"]["a_n"], "B_n": p["road_load"]["b_n_s_per_m"],
        "C_n": p["road_load"]["c_n_s2_per_m2"], "wind": p["headwind"]["speed_mps"],
        "slope": p["road_grade"]["slope"],
        "w_max": p["motor"]["omega_max"], "psi_m": p["motor"]["psi"],
    }  # fmt: skip
    finite = {k: 1e30 if v == inf else float(v) for k, v in values.items()}
    (folder / "p").write_text("".join(f"{k} {v!r}\n" for k, v in finite.items()))
    rows = zip(cycle.time_s, cycle.speed_mps, strict=True)
    (folder / "c").write_text("".join(f"{float(t)!r} {float(v)!r}\n" for t, v in rows))
    program = folder / "model"
    subprocess.run(["gcc", "-O2", "-o", program, HERE / "model.c", "-lm"], check=True)
    ticks = round(cycle.duration / finite["T"])
    return [str(program), str(folder / "p"), str(folder / "c"), str(ticks), "10", "1"]


def against_fastsim(truck: Vehicle, udds: Cycle) -> None:
    """Time FASTSim 3 on the same cycle."""
    if importlib.util.find_spec("fastsim") is None:
        print("FASTSim: left out, not installed")
        return
    import fastsim

    drive = fastsim.SimDrive(
        fastsim.Vehicle.from_resource("2022_Renault_Zoe_ZE50_R135.yaml"),
        fastsim.Cycle.from_resource("udds.csv"),
    )
    ours, theirs = [], []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        simulate(truck, udds, imposed=True)
        ours.append(time.perf_counter() - start)
        start = time.perf_counter()
        drive.copy().walk()
        theirs.append(time.perf_counter() - start)
    mine, other = statistics.median(ours), statistics.median(theirs)
    print(
        f"imposed UDDS, 1 Hz: {1e3 * mine:.2f} ms against FASTSim {fastsim.__version__}"
        f" {1e3 * other:.1f} ms: ratio {mine / other:.3f}"
    )


def show(label: str, run: Callable[[], object]) -> None:
    """Print the median time of a call, after one to warm up."""
    run()
    took = []
    for _ in range(5 * ROUNDS):
        start = time.perf_counter()
        run()
        took.append(time.perf_counter() - start)
    print(f"{label}: {1e3 * statistics.median(took):.2f} ms")


def whole_process(label: str, vehicle: str, *options: str) -> None:
    """Time the command from the shell, trace and ledger written to a file."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "rcc_sim", "simulate", vehicle, "--cycle",
                   "udds", *options, "-o", f"{folder}/out.csv"]  # fmt: skip
        took = []
        for _ in range(ROUNDS + 1):
            start = time.perf_counter()
            subprocess.run(command, check=True, capture_output=True)
            took.append(time.perf_counter() - start)
    print(f"{label}, whole process, trace written: {statistics.median(took[1:]):.2f} s")


if __name__ == "__main__":
    main()
