"""What is not for sure is said so: a cause that may be none, a proof on too little."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.proof.shrink import Shrink
from rcc_sim.report.doubts import SURE
from rcc_sim.report.screen import _ledger, _proof, _steps, _verdict


def found(probabilities=(), shrink=(0.9, 0.8, 1.0)):
    explained, low, high = shrink
    energy = SimpleNamespace(within=False, measured_wh=1.0)
    return SimpleNamespace(
        gaps=[SimpleNamespace(energy=energy, channels=())],
        status="explained",
        short=(),
        taken_up=False,
        found=SimpleNamespace(ranking={}),
        vehicle=load_vehicle("rcc"),
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


def test_a_figure_far_off_without_a_gap_is_said_to_be_what_is_wrong():
    one = found()
    one.status, one.moved = "no_gap", {"tyres.radius_m": -4.4}
    one.gaps[0].energy.within = True
    end = "if tyres.radius_m is 4.4 sds off what is stated: that is then what is wrong"
    assert _verdict(one).endswith(end)
    one.found.ranking = {"wheel_radius": 9.0, "headwind": 6.0}  # the first is itself
    assert _verdict(one).endswith(f"{end}, or headwind acts in its place")
    one.found.ranking = {"headwind": 4.5, "payload": 2.0}  # it costs 9.7 nats
    assert _verdict(one).endswith(end)
    one.moved = {"tyres.radius_m": -2.0}
    assert "tyres" not in _verdict(one)


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
        causes={},
        figures_wh=by_figures,
        unexplained_wh=0.01,
        meters_wh=0.0,
        drive_wh=0.0,
    )
    one.gap = one.gaps[0]
    text = "shifts of stated figures −0.06 Wh, unexplained +0.01 Wh"
    assert [*_ledger(one)] == [("ENERGY", text)] * told


@pytest.mark.parametrize(
    ("tied", "told"), [((), "a +0.4 Wh"), (("b",), "a or what ties with it +0.4 Wh")]
)
def test_the_energy_of_a_tie_is_not_that_of_its_first_alone(tied, told):
    one = found()
    one.prices = SimpleNamespace(
        causes={"a": 0.4},
        figures_wh=0.0,
        unexplained_wh=0.01,
        meters_wh=0.0,
        drive_wh=0.0,
    )
    one.gap = one.gaps[0]
    one.asserted = [SimpleNamespace(cause=SimpleNamespace(effect="a", tied=tied))]
    ((word, text),) = _ledger(one)
    assert word == "ENERGY" and text.startswith(f"{told}, ")


@pytest.mark.parametrize(
    ("power", "told"),
    [
        ([450, 450, 1650, 1650], ["low at first; half-way to the other end at 240 s"]),
        ([900, 900, 100, 900], ["high at first; half-way to the other end at 240 and "
                                "400 s"]),
        ([450, 450, 450, 450], []),  # it does not vary
        ([0, 9, 0, 9, 0, 9, 0, 9], []),  # it does so all the time
    ],
)  # fmt: skip
def test_when_a_load_is_switched_is_told(power, told):
    knots = np.array([0.0, 160.0, 320.0, 480.0, *range(500, 900, 100)])[: len(power)]
    value = np.array(power, dtype=float)
    load = Profile(
        "effects.auxiliary_load.power_w", "time_s", knots, value, value, 99.0
    )
    cause = Cause("auxiliary_load", (load.key,), 99.0, profiles={0: load})
    one = SimpleNamespace(cause=cause)
    assert list(_steps(SimpleNamespace(shown=0), one)) == told
    along = replace(load, along="distance_m")
    hill = SimpleNamespace(cause=replace(cause, profiles={0: along}))
    assert list(_steps(SimpleNamespace(shown=0), hill)) == []
