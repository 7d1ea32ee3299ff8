"""What a sweep is to run: grids, draws at each point, and what is refused."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcc_sim.batch.plan import make_plan, parse_axis
from rcc_sim.errors import InputError


@given(
    sizes=st.lists(st.integers(1, 4), min_size=1, max_size=3),
    draws=st.integers(1, 4),
    cut=st.tuples(st.integers(0, 300), st.integers(0, 300)),
)
def test_a_plan_is_every_combination_with_every_draw(sizes, draws, cut):
    settings = [f"k{i}.x={','.join(map(str, range(n)))}" for i, n in enumerate(sizes)]
    table = np.arange(draws, dtype=float)[:, None]
    plan = make_plan(settings, ("d.x",), table)
    whole = list(itertools.product(*(range(n) for n in sizes), range(draws)))
    assert plan.size == len(whole)
    start, stop = sorted(min(c, plan.size) for c in cut)
    got = plan.values(start, stop)
    assert got.tolist() == [list(map(float, row)) for row in whole[start:stop]]


@given(st.integers(0, 50), st.integers(1, 60))
def test_a_range_holds_both_its_ends_and_the_nearest_numbers_between(low, steps):
    axis = parse_axis(f"body.mass_kg={low}:{low + steps / 10}:0.1")
    assert axis.values == tuple(round(low + k / 10, 1) for k in range(steps + 1))


def test_values_and_ranges_may_stand_side_by_side():
    assert parse_axis("a.b=7,1:2:0.5,-3").values == (7, 1, 1.5, 2, -3)
    assert parse_axis("a.b=3:1:-1").values == (3, 2, 1)
    assert parse_axis("lanes.every=none,20").values == (np.inf, 20)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("body.mass_kg", "should be KEY=values"),
        ("body.mass_kg=", "should be KEY=values"),
        ("body.mass_kg=5:3:0.1", "an empty grid"),
        ("body.mass_kg=3:5:0", "an empty grid"),
        ("body.mass_kg=3:5", "should be lo:hi:step"),
        ("body.mass_kg=3:nan:1", "should be lo:hi:step"),
        ("body.mass_kg=3,heavy", "should be numbers"),
        ("body.mass_kg=3,inf", "should be numbers"),
        ("body.mass_kg=3,3", "a value twice"),
        ("body.mass_kg=0:1e12:1", "1,000,000,000,001 values"),
    ],
)
def test_an_axis_that_makes_no_sense_is_refused(text, words):
    with pytest.raises(InputError, match=words):
        parse_axis(text)


def test_a_million_millions_of_runs_are_refused_before_they_are_counted_out():
    settings = [f"a.{c}=1:10000:1" for c in "bcd"]
    with pytest.raises(InputError, match=r"1,000,000,000,000 runs"):
        make_plan(settings)


def test_a_key_of_the_cycle_or_the_lanes_that_does_not_exist_has_a_hint():
    with pytest.raises(InputError, match="no such key") as raised:
        make_plan(["cycle.speedscale=1,2"])
    assert "cycle.speed_scale" in raised.value.hint
    with pytest.raises(InputError, match="set twice"):
        make_plan(["a.b=1", "a.b=2"])
    with pytest.raises(InputError, match="touches the log alone"):
        make_plan(["sensors.speed_mps.noise_sd=1,2"])
