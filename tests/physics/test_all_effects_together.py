"""Any effects together, on any drive: the ledger closes, and both engines agree."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.simulate.run import LaneChanges, simulate
from tests.cars import car, truck
from tests.physics.test_effects import OFF_NEUTRAL

ALONE = {"road_load", "throttle_dead_zone", "throttle_gain"}
VALUES = {k: v for k, v in OFF_NEUTRAL.items() if k not in ALONE}
HELD = {
    "rotor_inertia": {"inertia_kgm2": 2e-6},  # holds wheels that slip
    "aerodynamic_drag": {"drag_area_m2": 0.05},  # what a headwind acts through
}


@st.composite
def some_effects(draw):
    """Some of the effects, each a random part of the way from neutral to its value."""
    chosen = draw(st.sets(st.sampled_from(sorted(VALUES))))
    made = dict(HELD)
    for name in sorted(chosen):
        part = draw(st.floats(0.25, 1.0))
        neutral = EFFECTS[name].neutral
        made[name] = {
            key: value
            if np.isinf(neutral[key])
            else neutral[key] + part * (value - neutral[key])
            for key, value in VALUES[name].items()
        }
    return made


drives = st.lists(st.floats(0, 7), min_size=3, max_size=6)


def driven(effects, speeds, lanes, imposed, engine="compiled"):
    cycle = Cycle("any", 1.0 * np.arange(len(speeds)), np.array(speeds))
    changes = LaneChanges(6.0) if lanes else None
    options = {"lanes": changes, "imposed": imposed, "engine": engine}
    return simulate(car(effects), cycle, **options)


@settings(max_examples=80)
@given(some_effects(), drives, st.booleans(), st.booleans())
def test_the_ledger_closes_with_any_effects(effects, speeds, lanes, imposed):
    run = driven(effects, speeds, lanes, imposed)
    assert abs(run.residual) < 1e-9
    assert all(np.isfinite(run.trace[c]).all() for c in run.trace.columns)
    assert (np.diff(run.trace["distance_m"]) >= 0).all()


@settings(max_examples=8)
@given(some_effects(), drives, st.booleans(), st.booleans())
def test_plain_python_and_machine_code_agree_with_any_effects(
    effects, speeds, lanes, imposed
):
    one, two = (
        driven(effects, speeds, lanes, imposed, engine)
        for engine in ("compiled", "interpreted")
    )
    assert one.trace.columns.keys() == two.trace.columns.keys()
    for column in one.trace.columns:
        assert np.array_equal(one.trace[column], two.trace[column]), column


@settings(max_examples=30)
@given(
    stiffness=st.floats(5e4, 1e7),
    slope=st.floats(-0.1, 0.1),
    limit=st.floats(0, 1000),
    speeds=st.lists(st.floats(0, 30), min_size=3, max_size=6),
    imposed=st.booleans(),
)
def test_a_truck_that_slips_and_brakes_closes_its_ledger(
    stiffness, slope, limit, speeds, imposed
):
    effects = {
        "longitudinal_slip": {"stiffness_n": stiffness},
        "rotor_inertia": {"inertia_kgm2": 0.2},
        "road_grade": {"slope": slope},
        "gear_loss": {"efficiency": 0.95},
        "regeneration_limit": {"max_torque_nm": limit},
        "rolling_resistance": {"coefficient": 0.01},
    }
    cycle = Cycle("any", 6.0 * np.arange(len(speeds)), np.array(speeds))
    run = simulate(truck(effects), cycle, imposed=imposed)
    assert abs(run.residual) < 1e-9
    assert (run.trace["motor_speed_radps"] >= 0).all()
