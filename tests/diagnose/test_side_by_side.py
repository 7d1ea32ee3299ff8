"""Work side by side: in order, one within the other, and ended by an error."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier, Event

import pytest

from rcc_sim.diagnose.fitting.engine import Engine


@pytest.fixture(params=[None, 1, 3], ids=["alone", "one more", "three more"])
def engine(request):
    engine = object.__new__(Engine)  # without a log
    engine.pool = ThreadPoolExecutor(request.param) if request.param else None
    return engine


def test_results_come_in_the_order_of_what_was_asked(engine):
    assert engine.each(lambda x: x * x, range(20)) == [x * x for x in range(20)]


def test_what_is_done_may_ask_likewise(engine):
    def row(i):
        return engine.each(lambda j: 10 * i + j, range(5))

    assert engine.each(row, range(6)) == [
        [10 * i + j for j in range(5)] for i in range(6)
    ]


def test_an_idle_thread_takes_its_share():
    engine = object.__new__(Engine)
    engine.pool = ThreadPoolExecutor(1)
    both = Barrier(2, timeout=10)  # passed only if two are at it at once
    assert len(engine.each(lambda _: both.wait(), range(2))) == 2


@pytest.mark.parametrize("at", [0, 3, 7])
def test_an_error_is_raised_and_nothing_goes_on(engine, at):
    def do(i):
        if i == at:
            raise KeyError(i)
        return i

    with pytest.raises(KeyError):
        engine.each(do, range(8))
    assert engine.each(do, range(at)) == list(range(at))


@pytest.mark.parametrize("good", [0, 1, 2])
def test_the_first_that_is_good_is_taken(engine, good):
    assert engine.first(lambda x: 2 * x, (0, 1, 2), lambda x: x >= 2 * good) == 2 * good


def test_none_is_good(engine):
    assert engine.first(lambda x: x, (0, 1, 2), lambda x: x > 5) is None


def test_one_that_was_worked_ahead_is_taken_from_there():
    engine = object.__new__(Engine)
    engine.pool = ThreadPoolExecutor(1)
    begun, made = Event(), []

    def do(x):
        if x == 1:
            begun.set()
        elif x == 0:
            begun.wait(10)  # until the other thread is at the next
        made.append(x)
        return x

    assert engine.first(do, (0, 1, 2), lambda x: x == 1) == 1
    assert sorted(made)[:2] == [0, 1] and made.count(1) == 1
