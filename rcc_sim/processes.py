"""Parts of a long work, done in processes of this machine side by side.

A process that dies is replaced, and its parts are done again. An interrupt is heard by
the one that started them alone, and ends them.
"""

from __future__ import annotations

import contextlib
import gc
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from types import FrameType
from typing import Any

from rcc_sim.errors import RccError

Work = Callable[[Any, Any], Any]
Parts = Iterable[tuple[int, Any]]
Results = Iterator[tuple[int, Any]]

AHEAD = 4
"""Parts that wait for each process, so that none waits for work."""

MOST_DEATHS = 3
"""How often processes may die one after the other, and no part be done between."""

ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "NUMBA_NUM_THREADS",
    ),
    "1",
)
"""What keeps a process of many to one thread."""


@contextlib.contextmanager
def working(
    work: Work, setup: Any, jobs: int, hint: str = ""
) -> Iterator[Callable[[Parts], Results]]:
    """Give the function that does parts, in so many processes; 1 works in this one.

    Results come in any order. The ``hint`` is told where processes die.

    Raises
    ------
    RccError
        If processes die one after the other.
    """
    if jobs <= 1:
        yield lambda parts: ((key, work(setup, part)) for key, part in parts)
        return
    pool = _Pool(work, setup, jobs, hint)
    try:
        yield pool.done
    finally:
        pool.close()


_here: dict[str, Any] = {}


def _begin(work: Work, setup: Any) -> None:
    """Start a process of the pool: it ends with the one that started it."""
    import multiprocessing

    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_follow, args=(parent,), daemon=True).start()
    _here.update(work=work, setup=setup)


def _follow(parent: Any) -> None:
    parent.join()
    os._exit(1)


def _do(part: Any) -> Any:
    return _here["work"](_here["setup"], part)


@contextlib.contextmanager
def _unheard() -> Iterator[None]:
    """Let an interrupt wait: a process that starts meanwhile never hears of one.

    Nor does this one: another of its threads may take what this thread blocks, and
    Python would raise it here, where a pool is half made.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # which would unblock what is blocked
    raises = signal.getsignal(signal.SIGINT)
    waits = callable(raises) and threading.current_thread() is threading.main_thread()
    heard: list[tuple[int, FrameType | None]] = []
    if waits:
        signal.signal(signal.SIGINT, lambda *given: heard.append(given))
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if waits:
            signal.signal(signal.SIGINT, raises)
        if heard and callable(raises):
            raises(*heard[0])


class _Pool:
    """A pool of processes that is built anew when one of them is killed."""

    def __init__(self, work: Work, setup: Any, jobs: int, hint: str) -> None:
        self.work, self.setup, self.jobs, self.hint = work, setup, jobs, hint
        self.pool: Any = None
        self.waiting: dict[Any, tuple[int, Any]] = {}
        self.deaths = 0

    def _new(self) -> Any:
        import multiprocessing
        from concurrent.futures import ProcessPoolExecutor

        os.environ |= ONE_THREAD  # what a new process starts with
        return ProcessPoolExecutor(
            self.jobs,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_begin,
            initargs=(self.work, self.setup),
        )

    def close(self) -> None:
        """End the processes; what they were at is not waited for."""
        if self.pool is None:
            return
        with _unheard():
            processes = list((self.pool._processes or {}).values())
            # they hold semaphores
            manager, asked = self.pool._executor_manager_thread, self.pool._call_queue
            self.pool.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.terminate()
            for process in processes:
                process.join(timeout=5)
            with contextlib.suppress(OSError):
                asked._reader.close()  # what is written to none that reads never ends
            if manager is not None:
                manager.join(timeout=5)
            self.pool = manager = asked = None
            gc.collect()  # its semaphores are given back

    def done(self, parts: Parts) -> Results:
        """Give the results as they come."""
        from concurrent.futures import FIRST_COMPLETED, wait
        from concurrent.futures.process import BrokenProcessPool

        left = iter(parts)
        more = True
        while more or self.waiting:
            while more and len(self.waiting) < AHEAD * self.jobs:
                item = next(left, None)
                more = item is not None
                if item is not None:
                    self._give(item)
            ready, _ = wait(self.waiting, return_when=FIRST_COMPLETED)
            died = False
            for future in ready:
                if isinstance(future.exception(), BrokenProcessPool):
                    died = True
                    continue
                key, _ = self.waiting.pop(future)
                self.deaths = 0
                yield key, future.result()
            if died:
                self._again()

    def _give(self, item: tuple[int, Any]) -> None:
        from concurrent.futures.process import BrokenProcessPool

        try:
            self._submit(item)
        except BrokenProcessPool:
            self._again()
            self._submit(item)

    def _submit(self, item: tuple[int, Any]) -> None:
        with _unheard():
            self.pool = self.pool or self._new()
            self.waiting[self.pool.submit(_do, item[1])] = item

    def _again(self) -> None:
        """Replace the pool, and give it what the dead one had not done."""
        self.deaths += 1
        if self.deaths > MOST_DEATHS:
            raise RccError(
                f"the processes die: {self.deaths} times without a part done",
                f"is there memory for {self.jobs}? {self.hint}".rstrip(),
            )
        lost = {f: item for f, item in self.waiting.items() if not _succeeded(f)}
        self.close()
        for future in lost:
            del self.waiting[future]
        for item in lost.values():
            self._give(item)


def _succeeded(future: Any) -> bool:
    return future.done() and not future.cancelled() and future.exception() is None
