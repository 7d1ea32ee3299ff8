"""What rows held out may not show at all is an even chance at most."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose import run
from rcc_sim.diagnose.judge.verdict import EVEN
from rcc_sim.diagnose.proof.hold_out import UNPROVEN
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from tests.diagnose.test_both_ends import EXACT, NOISE

CAR = load_vehicle("rcc")


@pytest.fixture(scope="module")
def drive():
    """Drive half a minute with 2 W more than the file has."""
    town = parse_cycle("udds[20:160]")
    cycle = Cycle("c", 0.2256 * town.time_s, 0.416 * town.speed_mps)
    true = CAR.changed(effects={"auxiliary_load": {"power_w": 6.0}})
    log = simulate(true, cycle, output_rate=20.0).trace
    rng = np.random.default_rng(3)
    seen = {n: log[n] + rng.normal(0, s, len(log)) for n, s in NOISE.items()}
    return Logged(Trace({n: log[n] for n in EXACT} | seen, name="drive"), (), None)


@pytest.mark.parametrize(
    ("low", "sure"), [(None, True), (UNPROVEN.low, False), (0.0, False)]
)
def test_a_cause_is_as_sure_as_what_no_fit_saw_lets_it_be(
    monkeypatch, drive, low, sure
):
    true_proof = run.proof

    def proof(*of, **how):
        found = true_proof(*of, **how)
        assert found.shrink.low > 0.5
        least = found.shrink.low if low is None else low
        return replace(found, shrink=replace(found.shrink, low=least))

    monkeypatch.setattr(run, "proof", proof)
    found = run.diagnose([drive], CAR, candidates=("auxiliary_load", "copper_loss"))
    (cause,) = found.asserted
    assert cause.cause.effect == "auxiliary_load"
    assert (cause.probability > EVEN) == sure
    assert found.status == ("explained" if sure else "partly_explained")
