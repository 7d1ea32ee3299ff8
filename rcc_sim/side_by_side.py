"""Threads that share work: who waits for a piece of it does what others have asked.

A piece may ask for pieces of its own. A pool of workers leaves whoever waits idle, and
a lone worker alone with all that its own piece asks; here none is while anything is
left to do, and no more threads run than may.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from functools import partial
from itertools import zip_longest
from typing import Any, NamedTuple, TypeVar

T = TypeVar("T")
R = TypeVar("R")

THREADS = 2
"""Threads of a process that run kernels side by side, unless the user says less."""


def threads() -> int:
    """Return the threads that a process may use: OMP_NUM_THREADS, at most two.

    Where many processes share the cores, each is told to keep to one.
    """
    said = os.environ.get("OMP_NUM_THREADS", "")
    return min(int(said), THREADS) if said.isdecimal() and int(said) > 0 else THREADS


class Piece(NamedTuple):
    """A piece of work, and how many others it was asked within."""

    do: Callable[[], Any]
    result: Future[Any]
    depth: int


class Crew:
    """Threads, and what they have yet to do.

    Parameters
    ----------
    threads : callable
        Returns how many may be at work, the one that asks among them.
    """

    def __init__(self, threads: Callable[[], int] = threads) -> None:
        self.threads = threads
        self.asked: list[Piece] = []
        self.helpers = 0
        self._changed = threading.Condition()
        self._here = threading.local()

    @property
    def depth(self) -> int:
        """How many pieces this thread is within."""
        return getattr(self._here, "depth", 0)

    def begin(self, do: Callable[[], R]) -> Future[R]:
        """Ask for a piece of work; a thread that is idle begins it."""
        result: Future[R] = Future()
        with self._changed:
            self.asked.append(Piece(do, result, self.depth))
            if self.helpers < self.threads() - 1:
                self.helpers += 1
                threading.Thread(target=self._help, daemon=True).start()
            self._changed.notify_all()
        return result

    def end(self, result: Future[R]) -> R:
        """Return what a piece of work makes, doing it or others while it is not made.

        Others are those that were asked within as many as it, or more: what is done
        while waiting then waits for less and less.
        """
        while (piece := self._next(self.depth, result)) is not None:
            self._do(piece)
        return result.result()

    def drop(self, result: Future[Any]) -> bool:
        """Ask no more for a piece of work; tell whether none had begun it."""
        with self._changed:
            for i, piece in enumerate(self.asked):
                if piece.result is result:
                    del self.asked[i]
                    return True
        return False

    def each(self, do: Callable[[T], R], many: Sequence[T]) -> list[R]:
        """Do the same with each of many things, side by side; what is made of each."""
        return list(self.in_turn(do, many)) if len(many) > 1 else list(map(do, many))

    def in_turn(self, do: Callable[[T], R], many: Sequence[T]) -> Iterator[R]:
        """Return what is made of each of many things, in their order, as it is made.

        An idle thread is at it before the first is asked for.
        """
        return self._ended([self.begin(partial(do, one)) for one in many])

    def _ended(self, asked: Sequence[Future[R]]) -> Iterator[R]:
        try:
            for one in asked:
                yield self.end(one)
        finally:  # one went wrong, or no more is wanted
            for one in asked:
                self.drop(one)

    def first(
        self, do: Callable[[T], R], many: Sequence[T], good: Callable[[R], bool]
    ) -> R | None:
        """Return what is made of the first of many things if it is good, else the next.

        None if none is. A thread that is idle works one ahead.
        """
        ahead: Future[R] | None = None
        try:
            for one, then in zip_longest(many, many[1:]):
                asked, ahead = ahead, None
                if then is not None:
                    ahead = self.begin(partial(do, then))
                made = do(one) if asked is None or self.drop(asked) else asked.result()
                if good(made):
                    return made
            return None
        finally:  # one went wrong, or no more is wanted
            if ahead is not None:
                self.drop(ahead)

    def _next(self, depth: int, awaited: Future[Any] | None = None) -> Piece | None:
        """Wait for a piece: the awaited one, or that of most depth of so much at least.

        None once the awaited one is made.
        """

        def rank(i: int) -> tuple[bool, int]:
            return self.asked[i].result is awaited, self.asked[i].depth

        with self._changed:
            while awaited is None or not awaited.done():
                found = max(range(len(self.asked)), key=rank, default=None)
                if found is not None and rank(found) >= (False, depth):
                    return self.asked.pop(found)
                self._changed.wait()
        return None

    def _do(self, piece: Piece) -> None:
        before, self._here.depth = self.depth, piece.depth + 1
        try:
            piece.result.set_result(piece.do())
        except BaseException as error:
            piece.result.set_exception(error)
            if not isinstance(error, Exception):
                raise
        finally:
            self._here.depth = before
            with self._changed:
                self._changed.notify_all()

    def _help(self) -> None:
        while (piece := self._next(0)) is not None:
            self._do(piece)


CREW = Crew()
"""The threads of this process."""

each, in_turn, first = CREW.each, CREW.in_turn, CREW.first
