"""Evidence adds up over logs: by the laws of least squares, and against chance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.diagnose.fleet.pool import Evidence, Strength, packed, unpacked
from rcc_sim.diagnose.fleet.pooled import POOLED_ENOUGH, pool, screen

ROWS = 200
SD = np.array([0.5, 2.0])
WIND = Strength("headwind", "effects.headwind.speed_mps", 0.0, -50.0, 50.0)
DRAG = Strength("payload", "effects.payload.mass_kg", 0.0, -50.0, 50.0)


def logs(rng, n, strength, off=(0.0, 0.0), scatter=0.0, noise=1.0):
    """Return rows of linear logs: two tolerances, two candidates, unit noise."""
    found = []
    for _ in range(n):
        A = rng.normal(size=(ROWS, 4)) * 0.2
        x = strength + scatter * rng.normal()
        y = A @ np.array([*off, x, 0.0]) + noise * rng.normal(size=ROWS)
        found.append((A, y))
    return found


def evidence(rows):
    """Return the evidence of one linear log."""
    A, y = rows
    return Evidence(("a", "b"), SD, (WIND, DRAG), A.T @ y, A.T @ A)


def best(found, effect="headwind"):
    """Return what is said of an effect."""
    return next(p for p in found if p.effect == effect)


def test_the_pooled_strength_is_that_of_one_regression_over_all_rows(rng):
    found = logs(rng, 12, 0.3, off=(0.4, -1.0))
    one = best(screen({"car": [evidence(r) for r in found]}, ()))
    A = np.vstack([r[0][:, :3] for r in found] + [np.diag([*1 / SD, 0.0])])
    y = np.concatenate([r[1] for r in found] + [np.zeros(3)])
    (a, b, x), *_ = np.linalg.lstsq(A, y, rcond=None)
    without, *_ = np.linalg.lstsq(A[:, :2], y, rcond=None)
    gain = 0.5 * (
        np.sum((y - A[:, :2] @ without) ** 2) - np.sum((y - A @ [a, b, x]) ** 2)
    )
    assert one.nats_common == pytest.approx(gain, rel=1e-6)
    if one.spread == 0:
        assert one.value == pytest.approx(x, rel=1e-6)


@pytest.fixture
def rng():
    """Return the same numbers each time."""
    return np.random.default_rng(5)


def test_what_each_log_is_too_weak_for_all_together_name(rng):
    found = {"car": [evidence(r) for r in logs(rng, 30, 0.5)]}
    explained = pool(found)
    (cause,) = explained.causes
    assert cause.found.effect == "headwind"
    assert cause.largest < POOLED_ENOUGH < cause.found.nats
    assert cause.found.low < 0.5 < cause.found.high


def test_a_figure_of_the_car_that_is_off_is_no_cause_however_many_logs():
    """Its pull is weighed once: 200 logs do not make one sd of the file a finding."""
    rng = np.random.default_rng(8)
    rows = []
    for _ in range(200):
        A = rng.normal(size=(ROWS, 4)) * 0.2
        A[:, 2] = A[:, 0] + 0.02 * rng.normal(size=ROWS)  # acts nearly as the figure
        rows.append((A, A @ [SD[0], 0.0, 0.0, 0.0] + rng.normal(size=ROWS)))
    one_car = best(screen({"car": [evidence(r) for r in rows]}, ()))
    own_cars = {str(k): [evidence(r)] for k, r in enumerate(rows)}
    assert one_car.nats < 5
    assert best(screen(own_cars, ())).nats > 50  # 200 cars off alike are one


def test_a_strength_that_scatters_about_zero_is_no_cause(rng):
    found = {"car": [evidence(r) for r in logs(rng, 30, 0.0, scatter=2.0)]}
    assert not pool(found).causes
    assert best(screen(found, ())).spread == pytest.approx(2.0, rel=0.4)


def test_one_odd_log_is_no_cause_of_all(rng):
    rows = [*logs(rng, 29, 0.0), *logs(rng, 1, 10.0)]
    assert not pool({"car": [evidence(r) for r in rows]}).causes


def test_what_an_interval_allows_not_to_act_at_all_is_no_cause(rng, monkeypatch):
    rows = {"car": [evidence(r) for r in logs(rng, 30, 0.5)]}
    assert pool(rows).causes

    def doubted(found, *_):
        return replace(found, low=-0.1)

    monkeypatch.setattr("rcc_sim.diagnose.fleet.pooled._doubted", doubted)
    assert not pool(rows).causes


def test_without_a_cause_hardly_any_fleet_names_one():
    rng = np.random.default_rng(11)
    named = sum(
        bool(pool({"car": [evidence(r) for r in logs(rng, 15, 0.0)]}).causes)
        for _ in range(200)
    )
    assert named == 0


def test_the_interval_of_a_scattering_strength_holds_its_mean():
    rng = np.random.default_rng(12)
    inside = 0
    for _ in range(60):
        rows = logs(rng, 20, 1.0, scatter=0.5)
        one = best(screen({"car": [evidence(r) for r in rows]}, ()))
        inside += one.low < 1.0 < one.high
    assert inside >= 54  # 90 % were promised


def test_a_log_that_lacks_a_channel_says_nothing_of_it(rng):
    rows = [evidence(r) for r in logs(rng, 10, 0.5)]
    without = Evidence(
        ("a",), SD[:1], (), rows[0].score[:1], rows[0].information[:1, :1]
    )
    alone = best(screen({"car": rows[1:]}, ()))
    both = best(screen({"car": [*rows[1:], without]}, ()))
    assert both.logs == alone.logs == 9
    assert both.value == pytest.approx(alone.value, rel=0.05)


def test_a_log_that_tells_of_nothing_at_all_is_passed_over(rng):
    rows = [evidence(r) for r in logs(rng, 10, 0.5)]
    nothing = Evidence((), SD[:0], (), np.zeros(0), np.zeros((0, 0)))
    alone, beside = (
        best(screen({"car": rows, **more}, ())) for more in ({}, {"other": [nothing]})
    )
    assert (beside.value, beside.nats) == (alone.value, alone.nats)


def test_evidence_comes_back_from_a_row_as_it_went(rng):
    one = evidence(logs(rng, 1, 0.5)[0])
    again = unpacked(*packed(one))
    assert again.strengths == one.strengths
    assert again.knobs == one.knobs
    assert np.array_equal(again.information, one.information)
    assert np.array_equal(again.score, one.score)
    assert np.array_equal(again.sd, one.sd)
