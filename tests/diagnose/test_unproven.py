"""What rows held out may not show at all is an even chance at most."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose import run
from rcc_sim.diagnose.judge.chances import EVEN
from rcc_sim.diagnose.proof import proven
from rcc_sim.diagnose.proof.shrink import UNPROVEN
from tests import scaled_drive

CAR = load_vehicle("rcc")


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """A drive with 2 W more than the file has."""
    true = CAR.changed(effects={"auxiliary_load": {"power_w": 6.0}})
    folder = tmp_path_factory.mktemp("drive")
    return scaled_drive.logged(scaled_drive.drive(true, None), CAR, 3, folder)


@pytest.mark.parametrize(
    ("nats", "sure"),
    [
        (None, True),
        (UNPROVEN.nats, False),
        pytest.param(-3.0, False, marks=pytest.mark.thorough),
    ],
)
def test_a_cause_is_as_sure_as_what_no_fit_saw_lets_it_be(monkeypatch, log, nats, sure):
    true_proof = proven.proof

    def proof(*of, **how):
        found = true_proof(*of, **how)
        assert found.shrink.low > 0.5 and found.shrink.nats > 100
        told = found.shrink.nats if nats is None else nats
        return replace(found, shrink=replace(found.shrink, nats=told))

    monkeypatch.setattr(proven, "proof", proof)
    found = run.diagnose([log], CAR, candidates=("auxiliary_load", "copper_loss"))
    (cause,) = found.asserted
    assert cause.cause.effect == "auxiliary_load"
    assert (cause.probability > EVEN) == sure
    assert found.status == ("explained" if sure else "partly_explained")


@pytest.mark.parametrize(
    ("varies", "imposed", "explained", "rests"),
    [
        (True, False, 0.07, True),
        (True, False, 0.4, False),
        (False, False, 0.07, False),  # its energy there is a prediction
        (True, True, 0.07, False),  # the speed's noise is in all that is left
    ],
)
def test_energy_of_rows_that_a_course_was_fitted_to_proves_nothing(
    varies, imposed, explained, rests
):
    drive = SimpleNamespace(drive=SimpleNamespace(imposed=imposed))
    causes = [SimpleNamespace(profiles={0: "a course"} if varies else {})]
    stands = SimpleNamespace(causes=causes, engine=SimpleNamespace(problems=[drive]))
    proof = SimpleNamespace(shrink=SimpleNamespace(explained=explained))
    assert proven.rests_on_a_course(stands, proof) == rests
