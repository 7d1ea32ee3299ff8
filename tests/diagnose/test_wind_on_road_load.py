"""Wind on a car whose file states a certified road load, and no drag area."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import has_needs
from rcc_sim.diagnose.run import diagnose
from rcc_sim.errors import InputError
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

WIND = 6.0
NOISE = {"speed_mps": 0.02, "battery_power_w": 150.0}


def driven(car, way, seed):
    """What a logger sees of a drive against the wind, or with it."""
    blown = car.changed(settings={"effects.headwind.speed_mps": way * WIND})
    run = simulate(blown, parse_cycle("us06"), output_rate=10).trace
    rng = np.random.default_rng(seed)
    seen = {c: run[c] + rng.normal(0, sd, len(run)) for c, sd in NOISE.items()}
    columns = {"time_s": run["time_s"], "direction": np.full(len(run), way), **seen}
    return Logged(Trace(columns, name=f"way {way:+.0f}"), (), None)


@pytest.fixture(scope="module")
def car():
    return load_vehicle("r1t_epa")


def test_one_way_it_is_named_or_tied_with_the_road_load(car):
    (one,) = diagnose([driven(car, 1.0, 3)], car).asserted
    assert {one.cause.effect, *one.cause.tied} >= {"headwind", "road_load"}
    figures = {one.cause.effect: one.figures, **one.instead}["headwind"]
    assert figures["speed_mps"].value == pytest.approx(WIND, rel=0.25)


def test_out_and_back_it_is_named_alone(car):
    found = diagnose([driven(car, 1.0, 3), driven(car, -1.0, 4)], car)
    (one,) = found.asserted
    assert (one.cause.effect, one.cause.tied) == ("headwind", ())
    speed = one.figures["speed_mps"]
    assert speed.low < WIND < speed.high
    assert speed.high - speed.low < 0.2 * WIND


def test_a_load_whose_square_part_is_not_the_airs_knows_no_wind(car):
    assert has_needs(car, EFFECTS["headwind"])
    fitted = car.changed(settings={"effects.road_load.c_n_s2_per_m2": -0.1})
    assert not has_needs(fitted, EFFECTS["headwind"])
    bare = car.changed(without=("road_load",))
    with pytest.raises(InputError, match="drag_area_m2: missing"):
        driven(bare, 1.0, 0)
