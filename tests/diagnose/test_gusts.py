"""A wind that comes and goes: named, and followed, out and on the way back."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.causes.strengths import Prior, likeliest, prior_of, windows
from rcc_sim.diagnose.deliver import acting, write_mended
from rcc_sim.diagnose.profiles.gusts import may_blow, may_gust
from rcc_sim.diagnose.run import diagnose
from rcc_sim.diagnose.search.look import free_of
from rcc_sim.trace import Trace
from tests.by_hand import STATED, logged, shaft_torque
from tests.cars import truck

KEY = "effects.headwind.speed_mps"
T = np.arange(0.0, 600.0, 0.1)


def blown(sign=1.0, **more):
    """A flat road, now fast, now slow, and a wind in gusts of a minute; the wind."""
    rng = np.random.default_rng(1)
    fade = np.exp(-0.1 / 60.0)
    kicks = np.sqrt(1 - fade**2) * rng.normal(size=len(T))
    wind = 1.0 + 8.0 * lfilter([1.0], [1.0, -fade], kicks)
    goal = np.repeat(rng.uniform(5.0, 32.0, 40), 150)
    v = lfilter([0.008], [1, -0.992], lfilter([0.03], [1, -0.97], goal))
    torque = shaft_torque(T, v, wind)
    log = logged(T, v, torque, rng)
    return Logged(Trace(log | more, name="gusts"), (), None), sign * wind


@pytest.mark.slow
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_it_is_named_and_followed(way, tmp_path):
    """On the way back, a wind of the file's blows from the other side."""
    log, wind = blown(way, **({} if way > 0 else {"direction": np.full(len(T), way)}))
    found = diagnose([log], truck(STATED))
    (one,) = found.asserted
    assert one.cause.effect == "headwind"
    assert 0.5 <= one.probability < 0.99  # a drag that changes likewise is near
    value, _ = acting(found, one.cause)
    assert np.corrcoef(value, wind)[0, 1] > 0.95
    assert 0.8 < np.polyfit(wind, value, 1)[0] < 1.2
    write_mended(found, tmp_path / "mended.toml")
    mean = load_vehicle(str(tmp_path / "mended.toml")).figures()[KEY]
    assert mean.low < np.mean(wind) < mean.high


def test_gusts_have_next_to_no_mean():
    """A steady wind is a figure of its own: what tells little of 5 m/s finds none."""
    knots = np.linspace(0.0, 600.0, 21)
    x = np.linspace(0.0, 600.0, 3000)
    prior = prior_of(KEY, "time_s", knots)
    H = windows(x, knots).toarray()
    true = 4.0 * np.sin(x / 60.0) + 5.0
    M, b = H.T @ H / 30.0**2, H.T @ true / 30.0**2
    _, value, _, _ = likeliest(M, b, prior, H.mean(axis=0))
    _, free, _, _ = likeliest(M, b, Prior(prior.shape), H.mean(axis=0))
    assert abs(value.mean()) < 0.2 < 4.0 < free.mean()
    assert np.ptp(value) > 4.0


def gusty(most):
    knots = np.linspace(0.0, 600.0, 20)
    value = most * np.sin(np.arange(20.0))
    return Cause(
        "headwind", (KEY,), 100.0,
        profiles={0: Profile(KEY, "time_s", knots, value, 0 * knots + 1, 100.0)},
    )  # fmt: skip


def test_a_hurricane_is_no_wind():
    assert may_blow(gusty(15.0))
    assert not may_blow(gusty(40.0))
    assert may_blow(Cause("road_grade", (), 100.0))


def test_beside_gusts_no_other_drag_by_the_air_is_sought():
    def candidate(effect, key):
        return SimpleNamespace(
            effect=effect, several=False, searches=(SimpleNamespace(key=key),)
        )

    air = candidate("aerodynamic_drag", "effects.aerodynamic_drag.drag_area_m2")
    load = candidate("payload", "effects.payload.mass_kg")
    assert free_of([air, load], [gusty(5.0)]) == [load]
    assert free_of([air, load], [Cause("headwind", (KEY,), 100.0)]) == [air, load]


def test_gusts_are_sought_where_the_motion_drives_the_model():
    def engine(*imposed):
        drives = [SimpleNamespace(drive=SimpleNamespace(imposed=x)) for x in imposed]
        return SimpleNamespace(problems=drives)

    area = Cause("aerodynamic_drag", ("effects.aerodynamic_drag.drag_area_m2",), 50.0)
    assert may_gust(engine(True, True), [gusty(5.0)])
    assert not may_gust(engine(True, False), [])
    assert not may_gust(engine(True), [area])
