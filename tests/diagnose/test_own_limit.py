"""A user's own limit, which has no slope at neutral, competes like a shipped one."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.own_effects import own_effect
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.errors import InputError
from rcc_sim.simulate.run import simulate
from tests.diagnose.test_both_ends import EXACT, NOISE

FLAP = """
from math import inf

from rcc_sim.physics.effect import Effect, Param, Sought


def force(v, opens_mps):
    return 1.5 if v > opens_mps else 0.0


EFFECT = Effect(
    id="flap", title="a flap that opens at speed", equation="F = 1.5 N above it",
    channels=("motor_current_a",), seen_as="a step in current", source="this test",
    params=(
        Param("opens_mps", inf, (0.0, inf), (0.5, 4.0), "the speed"{sought}),
    ),
)
"""
TRUE = 1.9
RIVALS = ("aerodynamic_drag", "drivetrain_damping", "rolling_resistance")


@pytest.mark.parametrize(
    "sought",
    [
        "",
        pytest.param(
            ", sought=Sought(tried=(1.2, 1.8, 2.4), acts='steps')",
            marks=pytest.mark.thorough,
        ),
    ],
)
def test_it_is_named_and_found_near_where_it_acts(tmp_path, sought):
    file = tmp_path / "flap.py"
    file.write_text(FLAP.replace("{sought}", sought))
    car = load_vehicle("rcc").changed(files=(str(file),))
    udds = parse_cycle("udds[20:330]")
    cycle = Cycle("c", 0.2256 * udds.time_s, 0.416 * udds.speed_mps)
    true = car.changed(effects={"flap": {"opens_mps": TRUE}})
    run = simulate(true, cycle, output_rate=50.0).trace
    rng = np.random.default_rng(5)
    log = run.columns | {
        n: run[n] + rng.normal(0, s, len(run)) for n, s in NOISE.items()
    }
    kept = {n: log[n] for n in (*EXACT, *NOISE)}
    path = tmp_path / "log.csv"
    rows = np.column_stack(list(kept.values()))
    np.savetxt(
        path, rows, fmt="%.6g", delimiter=",", header=",".join(kept), comments=""
    )
    found = diagnose([open_log(path, car)], car, candidates=("flap", *RIVALS))
    first = found.asserted[0]
    assert first.cause.effect == "flap"
    assert first.figures["opens_mps"].value == pytest.approx(TRUE, abs=0.2)
    assert len(found.asserted) == 1


def test_what_a_diagnosis_could_not_follow_is_refused_by_name(tmp_path):
    file = tmp_path / "flap.py"
    file.write_text(FLAP.replace("{sought}", ", sought=Sought(of='wait')"))
    with pytest.raises(InputError, match=r"opens_mps: sought\.of: 'wait'"):
        own_effect(str(file))
