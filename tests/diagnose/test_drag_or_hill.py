"""A drag that comes and goes with time may be taken for a hill: how sure is it then?"""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from rcc_sim.analyse.logged import Logged
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.judge.chances import probability
from rcc_sim.diagnose.profiles import drag_or_hill
from rcc_sim.diagnose.profiles.remainder import Remainder
from rcc_sim.diagnose.run import diagnose
from rcc_sim.report.doubts import is_a_drag_as_well
from rcc_sim.trace import Trace
from tests.by_hand import STATED, logged, shaft_torque
from tests.cars import truck

SLOPE = {0: SimpleNamespace(weighed=False, knots=np.zeros(20))}
NOTHING = Remainder(0.0, "", "", [])
FELT = SimpleNamespace(channels=("battery_power_w", "accel_x_mps2"))
UNFELT = SimpleNamespace(channels=("battery_power_w",))


@pytest.fixture
def hill(monkeypatch):
    """A hill of 180 nats, and what would be in its place, by any noise."""

    def found(
        effect="road_grade", drag=0.0, other=0.0, wind=0.0, own=180.0, sharp=1, log=FELT
    ):
        shares = np.array([1.0])
        rivals = (
            Remainder(drag, "drag", "time_s", [], shares=shares),
            Remainder(other, "drag", "speed_mps", [], shares=shares),
        )
        left = Remainder(drag, "drag", "time_s", [], shares=shares, rivals=rivals)
        one = Cause(effect, (), 180.0, profiles=SLOPE, shares=shares)
        nats = {
            "effects.road_grade.slope": own,
            "effects.headwind.speed_mps": sharp * wind,
            "effects.drivetrain_friction.torque_nm": sharp * drag,
        }
        weighed = lambda engine, fit, key, *how: nats.get(key, 0.0)  # noqa: E731
        monkeypatch.setattr(drag_or_hill, "with_own_noise", weighed)
        monkeypatch.setattr(drag_or_hill, "nats_of_gusts", lambda *logs: wind)
        fit = Fit({}, (), 0.0, 0.0, [], [])
        engine = SimpleNamespace(vehicle=truck(STATED), problems=[log])
        return drag_or_hill.beside_a_drag(engine, fit, one, left)

    return found


@pytest.mark.parametrize(
    ("drag", "least", "most"), [(180.0, 0.5, 0.5), (250.0, 0.5, 0.5),
                                (167.0, 0.9, 0.97), (100.0, 0.99, 1.0)],
)  # fmt: skip
@pytest.mark.parametrize("acts", ["drag", "wind"])
def test_it_is_as_sure_as_it_is_likelier_than_the_drag(hill, drag, least, most, acts):
    one = hill(**{acts: drag})
    chance = probability(one, NOTHING)
    assert least <= chance <= most
    told = SimpleNamespace(cause=one, probability=chance)
    assert is_a_drag_as_well(told) == (chance < 0.9)


def gusty_log(seed):
    """A flat motorway in gusts."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 900.0, 0.1)
    v = 27.0 + 4.0 * np.sin(t / 47.0) + 2.0 * np.sin(t / 19.0) - 27.0 * np.exp(-t / 9.0)
    fade = np.exp(-0.1 / 40.0)
    wind = 5.0 + lfilter(
        [1.2 * np.sqrt(1 - fade**2)], [1, -fade], rng.normal(size=len(t))
    )
    torque = shaft_torque(t, v, wind)
    return Trace(logged(t, v, torque, rng), name="gusts")


@pytest.mark.slow
def test_gusts_on_a_flat_road_are_no_sure_hill():
    found = diagnose([Logged(gusty_log(1), (), None)], truck(STATED))
    hills = [a for a in found.asserted if a.cause.effect == "road_grade"]
    assert all(a.probability < 0.7 for a in hills)
    assert found.status != "no_gap"


@pytest.mark.parametrize("acts", ["drag", "wind"])
def test_in_doubt_each_is_weighed_with_the_noise_that_it_leaves(hill, acts):
    """Before any acts the noise holds the hill, and what was felt of it."""
    one = hill(**{acts: 250.0}, own=600.0, sharp=2)
    assert one.gain - one.rival == pytest.approx(100.0)
    assert probability(one, NOTHING) > 0.99
    other = hill(**{acts: 170.0}, own=300.0, sharp=2)
    assert probability(other, NOTHING) == 0.5
    clear = hill(**{acts: 100.0}, own=0.0)  # what is no doubt is not weighed again
    assert clear.rival == 100.0


def test_what_no_accelerometer_felt_is_as_sure_as_the_smaller_lead(hill):
    """Nothing in the log parts a slope from a drag of the same course."""
    felt, unfelt = (
        probability(hill(drag=172.0, own=600.0, sharp=2, log=log), NOTHING)
        for log in (FELT, UNFELT)
    )
    assert felt > 0.99
    assert 0.85 < unfelt < 0.9  # of 8 nats
    assert probability(hill(drag=100.0, log=UNFELT), NOTHING) > 0.99


def test_what_follows_the_speed_and_other_causes_are_no_matter(hill):
    assert probability(hill(other=250.0), NOTHING) > 0.99
    assert hill("auxiliary_load", drag=250.0).rival == 0.0
