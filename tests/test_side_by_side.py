"""Work side by side: in order, one within the other, and ended by an error."""

from threading import Barrier, Event, current_thread

import pytest

from rcc_sim.side_by_side import Crew


@pytest.fixture(params=[1, 2, 4], ids=["alone", "one more", "three more"])
def crew(request):
    return Crew(lambda: request.param)


def test_results_come_in_the_order_of_what_was_asked(crew):
    assert crew.each(lambda x: x * x, range(20)) == [x * x for x in range(20)]


def test_what_is_done_may_ask_likewise(crew):
    def row(i):
        return crew.each(lambda j: 10 * i + j, range(5))

    assert crew.each(row, range(6)) == [
        [10 * i + j for j in range(5)] for i in range(6)
    ]


def test_an_idle_thread_takes_its_share():
    crew = Crew(lambda: 2)
    both = Barrier(2, timeout=10)  # passed only if two are at it at once
    assert len(crew.each(lambda _: both.wait(), range(2))) == 2


@pytest.mark.parametrize("at", [0, 3, 7])
def test_an_error_is_raised_and_nothing_goes_on(crew, at):
    def do(i):
        if i == at:
            raise KeyError(i)
        return i

    with pytest.raises(KeyError):
        crew.each(do, range(8))
    assert crew.each(do, range(at)) == list(range(at))


@pytest.mark.parametrize("good", [0, 1, 2])
def test_the_first_that_is_good_is_taken(crew, good):
    assert crew.first(lambda x: 2 * x, (0, 1, 2), lambda x: x >= 2 * good) == 2 * good


def test_none_is_good(crew):
    assert crew.first(lambda x: x, (0, 1, 2), lambda x: x > 5) is None


def test_one_that_was_worked_ahead_is_taken_from_there():
    crew = Crew(lambda: 2)
    begun, made = Event(), []

    def do(x):
        if x == 1:
            begun.set()
        elif x == 0:
            begun.wait(10)  # until the other thread is at the next
        made.append(x)
        return x

    assert crew.first(do, (0, 1, 2), lambda x: x == 1) == 1
    assert sorted(made)[:2] == [0, 1] and made.count(1) == 1


def test_who_waits_does_what_the_other_has_asked():
    """Both are at the pieces of a piece, though one of them waits for it alone."""
    crew = Crew(lambda: 2)
    begun, at = Event(), Barrier(2, timeout=10)

    def long(_):
        begun.set()
        crew.each(lambda _: at.wait(), range(2))  # passed only if two are at it
        return current_thread()

    def short(_):
        return begun.wait(10) and current_thread()

    one, other = crew.each(lambda do: do(0), [long, short])
    assert one is not other


def test_an_interrupt_comes_through_and_drops_what_nobody_has_begun():
    crew, made = Crew(lambda: 1), []

    def do(i):
        made.append(i)
        if i == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        crew.each(do, range(5))
    assert made == [0, 1] and not crew.asked


def test_what_waits_within_a_piece_begins_no_other_that_is_as_far_out():
    """Else a long row of pieces would be as deep, one within the wait of another."""
    crew, depth, most = Crew(lambda: 2), {}, 0

    def piece(_):
        nonlocal most
        mine = current_thread()
        depth[mine] = depth.get(mine, 0) + 1
        most = max(most, depth[mine])
        crew.each(lambda _: sum(range(2000)), range(4))
        depth[mine] -= 1

    crew.each(piece, range(200))
    assert most == 1
