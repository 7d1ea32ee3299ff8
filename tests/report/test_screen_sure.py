"""What is not for sure is said so: a cause that may be none, a proof on too little."""

from types import SimpleNamespace

import pytest

from rcc_sim.diagnose.proof.shrink import Shrink
from rcc_sim.report.doubts import SURE
from rcc_sim.report.screen import _ledger, _proof, _verdict


def found(probabilities=(), shrink=(0.9, 0.8, 1.0)):
    explained, low, high = shrink
    energy = SimpleNamespace(within=False, measured_wh=1.0)
    return SimpleNamespace(
        gaps=[SimpleNamespace(energy=energy, channels=())],
        status="explained",
        short=(),
        taken_up=False,
        moved={},
        asked=(),
        asserted=[SimpleNamespace(probability=p) for p in probabilities],
        proof=SimpleNamespace(
            shrink=Shrink(1.0, 1.0 - explained, explained, low, high),
            before=None,
            after=None,
            by_torque=False,
        ),
        kept_back=(),
        courses_fitted=False,
    )


@pytest.mark.parametrize(
    ("probabilities", "told"),
    [
        ((0.995,), "explained"),
        ((0.995, SURE), "explained"),
        ((0.995, 0.6), "explained; not for sure, at 60 %"),
        ((0.49,), "explained; less likely than not, at 49 %"),
        ((0.5, 0.99), "explained; as likely as not, at 50 %"),
    ],
)
def test_the_least_sure_cause_is_told_beside_the_verdict(probabilities, told):
    assert _verdict(found(probabilities)) == told


@pytest.mark.parametrize(
    ("shrink", "told"),
    [
        ((0.9, 0.8, 1.0), "(80 % to 100 %)"),
        (
            (0.8, -0.51, 1.0),
            "(−51 % to 100 %): hardly anything was, so that is not sure",
        ),
        ((0.8, -1.0, 1.0), "too little is beyond noise, row by row, to tell"),
    ],
)
def test_a_proof_that_may_be_none_says_so(shrink, told):
    ((word, text),) = _proof(found(shrink=shrink))
    assert word == "PROOF" and told in text


@pytest.mark.parametrize(("by_figures", "told"), [(-0.06, True), (0.0005, False)])
def test_without_a_cause_it_is_told_what_stated_figures_are_worth(by_figures, told):
    one = found()
    one.prices = SimpleNamespace(
        causes={}, figures_wh=by_figures, unexplained_wh=0.01, drive_wh=0.0
    )
    one.gap = one.gaps[0]
    text = "shifts of stated figures −0.06 Wh, unexplained +0.01 Wh"
    assert [*_ledger(one)] == [("ENERGY", text)] * told
