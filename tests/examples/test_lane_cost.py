"""The example of what lane changes cost says what its table says."""

import runpy
from pathlib import Path

import pytest

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.similitude.scale import Scales
from rcc_sim.simulate.run import LaneChanges

EXAMPLE = Path(__file__).parents[2] / "examples" / "lane_cost" / "lane_cost.py"


@pytest.mark.parametrize(("drive", "measured"), [("1", 17.5), ("2", 19.4)])
def test_what_is_unknown_about_the_car_does_not_reach_what_was_measured(
    drive, measured
):
    example = runpy.run_path(str(EXAMPLE))
    car, truck = load_vehicle("rcc"), load_vehicle("r1t")
    full = parse_cycle(example["DRIVES"][drive])
    small = example["scaled"](full, Scales.between(car, truck))
    for vehicle, cycle, every in ((truck, full, 50.0), (car, small, 20.0)):
        row = example["cost"](vehicle, cycle, LaneChanges(every), 40)
        assert 0 < row["low"] < row["high"] < measured / 3
