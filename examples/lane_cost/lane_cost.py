"""What lane changes cost, given what is not known about the car.

    python examples/lane_cost/lane_cost.py [DRAWS]

The paper's question with error bars. Each draw is a vehicle that the file admits (its
sds and ranges); it drives the paper's two drives straight and changing lanes, so that
what is unknown acts on both alike. A lane is one wheelbase wide, a change takes 20
wheelbases, one starts every 20 m (car) or 50 m (truck), as in the paper; the second
block narrows the change to 2.5 m every 5 m, to the width of a road lane in scale.
"""

from __future__ import annotations

import sys

from rcc_sim.batch.plan import Axis
from rcc_sim.batch.runs import Manoeuvre
from rcc_sim.batch.uncertain import paired_change
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import Vehicle, load_vehicle
from rcc_sim.similitude.scale import Scales
from rcc_sim.simulate.run import LaneChanges

DRIVES = {"1": "udds[510:680]", "2": "udds[20:125]"}
STRAIGHT = float("inf")
MEASURED = {"1": "17.5", "2": "19.4"}


def main() -> None:
    """Print the table."""
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    car, paper, truck = (load_vehicle(name) for name in ("rcc", "r1t", "r1t_epa"))
    print(f"{draws} draws; what lane changes cost as the file stands, and 90 %")
    print("drive  vehicle  lanes             cost [%]   from    to   (measured)")
    for name, words in DRIVES.items():
        full = parse_cycle(words)
        small = scaled(full, Scales.between(car, paper))
        for vehicle, cycle, lanes in (
            (paper, full, LaneChanges(50.0)),
            (truck, full, LaneChanges(50.0)),
            (car, small, LaneChanges(20.0)),
            (car, small, LaneChanges(5.0, 0.33, 2.5)),
        ):
            row = cost(vehicle, cycle, lanes, draws)
            words = f"every {lanes.every:g} m" + (", sharp" if lanes.length else "")
            value = row["wh_per_km_percent"]
            print(
                f"{name:5}  {vehicle.name:7}  {words:16} {value:8.3f}"
                f"  {row['low']:6.3f} {row['high']:6.3f}   ({MEASURED[name]})"
            )


def cost(
    vehicle: Vehicle, cycle: Cycle, lanes: LaneChanges, draws: int
) -> dict[str, float]:
    """Return what a drive costs more with lane changes than straight. [%]"""
    axis = Axis("lanes.every", (STRAIGHT, lanes.every))
    how = Manoeuvre(lanes=LaneChanges(STRAIGHT, lanes.width, lanes.length))
    return paired_change(vehicle, cycle, how, axis, draws)[0]


def scaled(cycle: Cycle, scales: Scales) -> Cycle:
    """Return a full-size drive at the car's scale."""
    time, speed = scales.of("time").value, scales.of("speed").value
    return Cycle(cycle.name, cycle.time_s * time, cycle.speed_mps * speed)


if __name__ == "__main__":
    main()
