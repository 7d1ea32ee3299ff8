"""Half the time step changes no shipped vehicle's energy, on any shipped cycle."""

from pathlib import Path

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.run import simulate

ROOT = Path(__file__).resolve().parents[2]
VEHICLES = sorted(path.stem for path in (ROOT / "vehicles").glob("*.toml"))
CYCLES = sorted(path.stem for path in (ROOT / "cycles").glob("*.csv"))
SCALE = 0.2256, 0.416  # of time and speed: the paper's car against its truck


def driven(vehicle, cycle, substeps):
    options = {"substeps": substeps, "output_rate": 1.0}
    if vehicle.controller.mode == "torque":
        return simulate(vehicle, cycle, **options)
    small = Cycle(cycle.name, SCALE[0] * cycle.time_s, SCALE[1] * cycle.speed_mps)
    if vehicle.controller.mode == "throttle":
        throttle = 0.5 * cycle.speed_mps / cycle.max_speed
        still = Cycle(cycle.name, small.time_s, 0.0 * small.speed_mps)
        options["throttle"] = small.time_s, throttle
        return simulate(vehicle, still, **options)
    return simulate(vehicle, small, **options)


@pytest.mark.parametrize("vehicle", VEHICLES)
@pytest.mark.parametrize("cycle", CYCLES)
def test_half_the_step_leaves_the_energy_of_every_vehicle_on_every_cycle(
    vehicle, cycle
):
    car, drive = load_vehicle(vehicle), parse_cycle(cycle)
    one, two = (driven(car, drive, n) for n in (1, 2))
    assert one.trace["distance_m"][-1] > 0.1 * np.ptp(one.trace["time_s"])
    assert one.battery_energy == pytest.approx(two.battery_energy, rel=1e-3)
