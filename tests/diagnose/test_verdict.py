"""What does not shrink on rows that no fit saw is explained in part alone."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.causes.sought import Search
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.judge import stands as verdicts
from rcc_sim.diagnose.judge.asserted import Asserted, estimates, resolution
from rcc_sim.diagnose.judge.chances import (
    EVEN,
    SUREST,
    chances_of,
    ends_early,
    probability,
)
from rcc_sim.diagnose.judge.energies import (
    grew,
    proves_nothing,
    stays_off,
    worsens,
)
from rcc_sim.diagnose.judge.ranking import ranking
from rcc_sim.diagnose.judge.stands import Standing, only, standing
from rcc_sim.diagnose.judge.verdict import Signs, verdict
from rcc_sim.diagnose.noise.whitener import Whitener
from rcc_sim.diagnose.profiles.forms import DRAG_OVER_TIME
from rcc_sim.diagnose.profiles.remainder import UNKNOWN_ENOUGH, Remainder
from rcc_sim.diagnose.proof.hold_out import Proof
from rcc_sim.diagnose.proof.proven import is_refuted
from rcc_sim.diagnose.proof.shrink import Shrink
from rcc_sim.diagnose.search.screen import Screen
from rcc_sim.diagnose.search.taken import outweighed
from rcc_sim.physics.effects import EFFECTS

CAUSE = Cause("payload", ("effects.payload.mass_kg",), 50.0)
NOTHING = Remainder(0.0, "drag", "", [])
SOMETHING = Remainder(UNKNOWN_ENOUGH + 1, "drag", "", [])


def comes_to(causes, left, *signs, **more):
    """Status of some causes, by what is left and signs."""
    return verdict(causes, left, Signs(*signs, **more)).status


@pytest.mark.parametrize(
    ("before", "after", "status"),
    [
        (69.6, 27.0, "partly_explained"),
        (69.6, -27.0, "partly_explained"),
        (69.6, 20.0, "explained"),
        (1.2, 1.4, "explained"),
        (-40.0, 3.0, "explained"),
        (None, None, "explained"),
    ],
)
def test_the_energy_gap_has_to_shrink_to_a_third(before, after, status):
    assert comes_to([CAUSE], NOTHING, before, after) == status


@pytest.mark.parametrize(
    ("before", "after", "larger"),
    [(0.4, 3.0, True), (-0.4, 3.0, True), (20.0, -0.4, False), (0.4, 1.0, False)],
)
def test_an_energy_gap_that_grew_is_called_so(before, after, larger):
    assert grew(before, after) is larger
    if larger:
        assert comes_to([CAUSE], NOTHING, before, after) == "partly_explained"


def test_a_gap_that_stated_figures_take_up_is_explained_in_part():
    assert comes_to([CAUSE], NOTHING) == "explained"
    assert comes_to([CAUSE], NOTHING, taken_up=True) == "partly_explained"


def test_the_ranking_says_what_the_status_says():
    gains = {f"effect {i}": 0.3 * i for i in range(40)}

    def likeliest(gains, left, asserted=(), status=""):
        found = SimpleNamespace(ranking=gains)
        rows = ranking(found, list(asserted), left, status)
        assert sum(r["probability"] for r in rows) == pytest.approx(1.0)
        assert rows[0]["probability"] > 0.5
        return rows[0]["effect"]

    assert likeliest(gains, NOTHING) == "none"
    assert likeliest(gains | {"withdrawn": 500.0}, NOTHING) == "none"
    assert likeliest(gains, NOTHING, status="unexplained") == "unknown"
    large = Remainder(UNKNOWN_ENOUGH + 30, "drag", "", [])
    assert likeliest(gains | {"withdrawn": 500.0}, large) == "unknown"
    sure = Asserted(CAUSE, 0.9, {})
    assert likeliest(gains | {"payload": 50.0}, NOTHING, [sure]) == "payload"


def test_what_a_cause_held_at_an_even_chance_leaves_is_not_lost():
    found = SimpleNamespace(ranking={"payload": 9000.0, "effect 1": 1.0})
    rows = ranking(found, [Asserted(CAUSE, EVEN, {})], SOMETHING, "partly_explained")
    chances = {r["effect"]: r["probability"] for r in rows}
    assert sum(chances.values()) == pytest.approx(1.0)
    assert chances == {"payload": EVEN, "unknown": EVEN, "effect 1": 0, "none": 0}


def test_what_the_less_sure_of_two_causes_leaves_is_not_lost():
    found = SimpleNamespace(ranking={"payload": 90.0, "load": 40.0, "other": 36.0})
    two = [Asserted(CAUSE, 0.99, {}), Asserted(replace(CAUSE, effect="load"), 0.7, {})]
    chances = {r["effect"]: r["probability"] for r in ranking(found, two, NOTHING)}
    others = {e: x for e, x in chances.items() if e not in ("payload", "load")}
    assert sum(others.values()) == pytest.approx(0.3)
    assert max(others, key=others.get) == "other"


def test_those_of_a_tie_share_its_probability_and_the_first_stays_first():
    found = SimpleNamespace(ranking={"payload": 50.0, "twin": 50.5, "other": 30.0})
    tie = Asserted(replace(CAUSE, tied=("twin",)), 0.9, {})
    rows = ranking(found, [tie], NOTHING)
    chances = {r["effect"]: r["probability"] for r in rows}
    assert sum(chances.values()) == pytest.approx(1.0)
    assert chances["payload"] == chances["twin"] == pytest.approx(0.45)
    assert rows[0]["effect"] == "payload"


def stands(effect, gain, change, sharpened=1.0, eased=0.0):
    key = f"effects.{effect}.x"
    white = Whitener(np.ones(50), np.zeros(0), [0, 1], 1.0, np.ones(50, bool))
    fit = Fit({key: 1.0}, (Knob(key, 1.0),), 0, 0, [white], [np.zeros(50)])
    engine = SimpleNamespace(
        residuals=lambda values: [np.ones(50) * (key not in values)]
    )
    own = Remainder(change, effect, "time_s", [], shares=np.zeros(1))
    left = Remainder(change, effect, "time_s", [], rivals=(own,))
    cause = Cause(effect, (key,), gain, sharpened=sharpened, eased=eased)
    return bool(standing(Standing(engine, fit, [cause], left)))


def test_a_cause_that_comes_and_goes_is_withdrawn():
    assert stands("rolling_resistance", 167.0, 12.0)
    assert not stands("rolling_resistance", 340.0, 47.0)
    assert not stands("drivetrain_friction", 74.0, 28.0)
    assert stands("current_limit", 3883.0, 30.0)
    assert stands("auxiliary_load", 100.0, 60.0)  # it may vary
    # by the noise that it leaves it gained more than by that in which it hid
    assert stands("drivetrain_friction", 123.0, 27.0, sharpened=3.3)
    assert stands("rolling_resistance", 135.0, 26.0, sharpened=1.6)
    assert not stands("drivetrain_friction", 157.0, 54.0, sharpened=1.7)


def test_what_stated_figures_would_be_off_by_without_it_counts_for_a_cause():
    """A load of 1012 kg was withdrawn, for a tyre 15 sds too large."""
    assert stands("payload", 337.5, 40.9, eased=291.3)
    assert not stands("payload", 337.5, 40.9)


def test_causes_that_stay_are_fitted_again_from_where_all_stood(monkeypatch):
    mass, load = Knob("body.mass_kg", 1500.0, 50.0), Knob("effects.payload.mass_kg", 0)
    null = Fit({mass.key: 300.0}, (mass,), 0, 0, [], [])
    all_of = Fit({mass.key: 1490.0, load.key: -690.0}, (mass, load), 0, 0, [], [])
    found = SimpleNamespace(null=null, engine=None, causes=())
    stays = Cause("payload", (load.key,), 50.0)
    now = Standing(None, all_of, [stays, CAUSE], NOTHING)
    begun = []
    monkeypatch.setattr(descent, "fit", lambda _, start, knobs: begun.append(start))
    monkeypatch.setattr(verdicts, "remainder", lambda *_: NOTHING)
    only(None, found, now, [stays])
    only(None, found, now, [])
    # a load of -690 kg beside a mass of 300 kg is no vehicle
    assert begun == [all_of.values, null.values]


def test_what_a_profile_holds_is_not_fitted_again_beside_it(monkeypatch):
    """A stated load that the tolerances had pulled up would come on top of it."""
    mass = Knob("body.mass_kg", 1500.0, 50.0)
    power = Knob("effects.auxiliary_load.power_w", 524.0, 60.0)
    null = Fit({mass.key: 1500.0, power.key: 1378.0}, (mass, power), 0, 0, [], [])
    drag = Knob("effects.payload.mass_kg", 0)
    both = Fit({mass.key: 1490.0, drag.key: 80.0}, (mass, drag), 0, 0, [], [])
    heater = Cause("auxiliary_load", (power.key,), 900.0, profiles={0: None})
    found = SimpleNamespace(null=null, engine=None, causes=(heater,))
    begun = []
    monkeypatch.setattr(descent, "fit", lambda _, start, knobs: begun.append(start))
    monkeypatch.setattr(verdicts, "remainder", lambda *_: NOTHING)
    only(None, found, Standing(None, both, [heater, CAUSE], NOTHING), [heater])
    assert begun == [{mass.key: 1490.0}]


def test_what_is_left_decides_where_nothing_is_named():
    assert comes_to([], NOTHING, 50.0, 50.0) == "no_gap"
    assert comes_to([], SOMETHING) == "unexplained"
    assert comes_to([], NOTHING, large=True) == "unexplained"
    assert comes_to([], NOTHING, wanders=True) == "unexplained"
    assert comes_to([], NOTHING, farthest=4.9) == "no_gap"
    assert comes_to([], NOTHING, farthest=6.3) == "unexplained"
    assert comes_to([CAUSE], SOMETHING, 50.0, 1.0) == "partly_explained"
    assert comes_to([CAUSE], NOTHING, explained=0.6) == "partly_explained"
    assert comes_to([CAUSE], NOTHING, explained=0.7) == "explained"
    assert comes_to([CAUSE], NOTHING, ends=True) == "partly_explained"
    assert comes_to([CAUSE], NOTHING, farthest=4.9) == "explained"
    assert comes_to([CAUSE], NOTHING, farthest=6.3) == "partly_explained"
    # within what is doubted, noise may leave it, but it must not grow
    beyond = {"doubtless": False, "noise": 2.0}
    assert comes_to([CAUSE], NOTHING, 24.0, 15.0, **beyond) == "partly_explained"
    assert comes_to([CAUSE], NOTHING, 2.5, 1.9, **beyond) == "explained"
    assert comes_to([CAUSE], NOTHING, 3.0, 2.9, doubtless=False) == "explained"
    assert comes_to([CAUSE], NOTHING, -0.1, -5.9, doubtless=False) != "explained"


def test_what_a_rough_road_may_be_is_real_where_the_energy_is_off_as_well():
    rough = Remainder(UNKNOWN_ENOUGH + 5, *DRAG_OVER_TIME, [])
    off = replace(rough, opens_gap=True)
    assert comes_to([], rough) == "no_gap"
    assert comes_to([], off) == "unexplained"
    assert comes_to([], replace(off, evidence=UNKNOWN_ENOUGH - 1)) == "no_gap"


def test_a_cause_that_needs_another_vehicle_is_an_even_chance_at_most():
    cause = Cause("payload", ("effects.payload.mass_kg",), 300.0)
    assert probability(cause, NOTHING, 9.0) == SUREST
    assert probability(cause, NOTHING, 15.5) == EVEN
    assert probability(cause, NOTHING, doubtful=True) == EVEN


def test_a_drag_is_no_surer_than_a_hill_that_may_be_another_drag():
    course = {0: Profile("effects.road_grade.slope", "distance_m", *np.ones((3, 2)), 9)}
    hill = Cause("road_grade", ("effects.road_grade.slope",), 200.0, profiles=course)
    doubted = replace(hill, rival=200.0)
    drag, load = (Cause(e, (), 300.0) for e in ("aerodynamic_drag", "auxiliary_load"))
    for beside, chances in (
        (hill, [SUREST, SUREST, SUREST]),
        (doubted, [EVEN, EVEN, SUREST]),
    ):
        every = [beside, drag, load]
        assert chances_of(every, NOTHING, 0.0, [False] * 3) == chances


def test_a_cause_is_as_sure_as_what_it_was_taken_in_by():
    """Where stated figures go back with it, that counts twice there, and here."""
    alone, with_figures = (
        Cause("road_load", ("effects.road_load.a_n",), 3.0, eased=x)
        for x in (0.0, 16.0)
    )
    assert probability(alone, NOTHING) < 0.2
    assert probability(with_figures, NOTHING) > 0.9
    rivalled = replace(with_figures, rival=2.9)
    assert probability(rivalled, NOTHING) == pytest.approx(EVEN)


@pytest.mark.parametrize(
    ("unknown", "stops"), [(30.0, False), (150.0, False), (250.0, True)]
)
def test_no_more_causes_are_sought_beside_an_unknown_that_outweighs_all(unknown, stops):
    """The weaker of two gained 100 nats, 200 by the noise it leaves."""
    where = np.array([0.0, 1.0])
    own = Remainder(unknown, "drag", "time_s", [], shares=where)
    left = Remainder(unknown, "drag", "time_s", [], rivals=(own,))
    one = Cause("payload", ("a",), 180.0, shares=where)
    two = Cause("drivetrain_friction", ("b",), 100.0, sharpened=2.0, shares=where)
    assert outweighed([one, two], left) is stops
    elsewhere = replace(one, shares=where[::-1])
    assert not outweighed([elsewhere, two], left)


def test_a_profile_that_does_nothing_for_rows_held_out_is_refuted():
    """Whatever tolerances allow: a load for a patch of ice explained 0.6 % of a gap."""
    gap = SimpleNamespace(energy=SimpleNamespace(noise_wh=0.09, measured_wh=0.4))
    load = Cause("auxiliary_load", ("effects.auxiliary_load.power_w",), 120.0)
    profile = SimpleNamespace(along="time_s", beside_drift=False)
    varying = replace(load, profiles={0: profile})

    def refuted(cause, explained, after, *, elsewhere=False):
        shrink = Shrink(0.1, 0.1, explained, -1.0, 1.0)
        proved = Proof(shrink, 35.8, after, by_torque=False)
        told = {"doubtless": False, "elsewhere": elsewhere}
        return is_refuted([cause], proved, [gap], **told)

    assert refuted(varying, -0.001, 36.5)
    assert not refuted(varying, -0.001, 12.0)  # the energy shrinks
    assert not refuted(varying, 0.9, 36.5)  # the rows do
    assert not refuted(load, -0.001, 36.5)  # too weak to show in either
    drift = SimpleNamespace(along="time_s", beside_drift=True)
    gauged = replace(load, profiles={0: drift})
    assert not refuted(gauged, -0.001, 36.5)  # a gauge that drifts takes the rest
    place = SimpleNamespace(along="distance_m", beside_drift=False)
    hill = replace(load, profiles={0: place})
    assert refuted(hill, -0.001, 36.5)
    assert not refuted(hill, -0.001, 36.5, elsewhere=True)  # of another road


def test_causes_that_do_nothing_for_rows_held_out_are_withdrawn():
    assert proves_nothing(0.023, 19.9, 19.3)
    assert not proves_nothing(0.023, 19.9, 12.0)  # the energy shrinks
    assert not proves_nothing(0.9, 19.9, 19.3)  # the rows do: a steering's offset
    assert not proves_nothing(0.023, None, None)  # no energy was measured


def test_an_energy_gap_has_to_shrink_to_a_third_or_beneath_the_noise():
    assert stays_off(18.5, -7.04, noise=4.6, doubtless=True)
    assert stays_off(18.5, -7.04, noise=4.6, doubtless=False)
    assert not stays_off(18.5, -7.04, noise=8.0, doubtless=False)
    assert not stays_off(18.5, -5.0, noise=4.6, doubtless=True)
    assert stays_off(1.0, 3.0, noise=8.0, doubtless=False)  # it grew
    assert not stays_off(None, None, noise=0.0, doubtless=True)


def test_causes_that_open_an_energy_gap_on_rows_held_out_are_refuted():
    assert worsens(0.7, -36.0, noise=5.7)
    assert worsens(12.0, -36.0, noise=5.7)
    assert worsens(0.7, -9.4, noise=5.7)  # friction and damping, for a sticking brake
    assert not worsens(0.7, -5.0, noise=5.7)  # noise could as well
    assert not worsens(20.0, -12.0, noise=5.7)  # it shrank
    assert not worsens(None, None, noise=5.7)


@pytest.mark.parametrize(
    ("value", "ends"), [(0.0, False), (0.03, False), (0.05, True), (0.3, False)]
)
def test_a_figure_at_its_own_bound_is_found_and_at_its_search_s_is_not(value, ends):
    key = "effects.rolling_resistance.coefficient"
    high = 0.05 if value < 0.1 else 0.3  # the effect's own
    knob = Knob(key, 0.01, low=0.0, high=high)
    fit = Fit({key: value}, (knob,), 0.0, 0.0, [], [])
    assert ends_early(Cause("rolling_resistance", (key,), 99.0), fit, EFFECTS) is ends


@pytest.mark.parametrize(
    ("key", "value", "row", "sd"),
    [
        ("effects.motor_lag.time_constant_s", 0.08, 0.01, 0.002),
        ("effects.steering_delay.delay_s", 0.08, 0.1, 0.02),
        ("effects.speed_dead_zone.threshold_radps", 50.0, 0.01, 1.5),
        ("effects.payload.mass_kg", 50.0, 0.01, 0.0),
    ],
)
def test_no_time_is_told_within_a_row_and_no_threshold_within_a_step(
    key, value, row, sd
):
    _, effect, name = key.split(".")
    knob = Knob(key, value, acts=EFFECTS[effect].param(name).acts)
    assert resolution(knob, value, row) == pytest.approx(sd)
    cause = Cause("any", (key,), 99.0)
    sharp = np.array([[1e12]])
    fit = Fit({key: value}, (knob,), 0.0, 0.0, [], [], sharp)
    (told,) = estimates(fit, cause, {}, row).values()
    assert told.high - told.value == pytest.approx(1.645 * sd, rel=1e-3, abs=1e-5)


@pytest.mark.parametrize("true", [31.0, 44.0, 58.0, 83.0])
def test_a_threshold_is_found_between_the_strengths_of_its_grid(true):
    grid = (10.0, 20.0, 30.0, 45.0, 60.0, 90.0)
    search = Search("x", 0.0, 0.0, 999.0, 1.0, grid, acts="steps")
    screen = object.__new__(Screen)

    def gain(x):  # flat between two commands: no slope
        return 100.0 - 5 * round(abs(np.log(x / true)) / 0.02)

    screen.signal = lambda values: values["x"]
    screen.gain, screen.promise = gain, lambda _: 0.0
    assert screen.scan(search, {})[1] == pytest.approx(true, rel=0.05)


def test_a_figure_is_as_unsure_as_the_fits_that_no_log_tells_apart():
    """Their mixture's second moment about the value that is told, in closed form."""
    rolls = Knob("effects.rolling_resistance.coefficient", 0.014, 0.003)
    drag, wind = Knob("effects.drivetrain_damping.damping_nms_per_rad", 0.0), "w"
    mine, other = (
        Fit({rolls.key: x, key.key: 1.0}, (rolls, key), 0, 0, [], [], np.diag(curve))
        for x, key, curve in (
            (0.016, drag, (1e6, 1.0)),
            (0.014, Knob(wind, 0.0), (4e6, 1.0)),
        )
    )
    found = mine.sd_among([other], rolls.key)
    assert found**2 == pytest.approx((1e-6 + 0.25e-6 + 0.002**2) / 2)
    assert mine.sd_among([], rolls.key) == pytest.approx(1e-3)
    assert mine.sd_among([other], drag.key) == pytest.approx(1.0)  # it has no other
    blind = replace(mine, information=np.zeros_like(mine.information))
    assert blind.sd_among([mine], rolls.key) > 1e100  # told by nothing, and no overflow
    cause = Cause("rolling_resistance", (rolls.key,), 50.0)
    alone, among = (
        estimates(mine, cause, {}, others=others)["coefficient"]
        for others in ((), [other])
    )
    assert among.value == alone.value
    assert (among.sd / alone.sd) ** 2 == pytest.approx(found**2 / 1e-6)


@pytest.mark.parametrize(("rival", "even"), [(49.2, True), (50.8, True), (44.0, False)])
def test_what_something_unknown_is_as_likely_as_is_explained_in_part(rival, even):
    """Within a nat the chances are even, and no wind is claimed."""
    wind = Cause("headwind", ("x",), 50.0, profiles={0: None}, rival=rival)
    chance = probability(wind, NOTHING)
    assert (chance == EVEN) is even
    told = "partly_explained" if even else "explained"
    assert comes_to([wind], NOTHING, even=chance <= EVEN) == told
