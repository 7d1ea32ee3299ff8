"""Where the parts of a batch are done: here, in processes of this machine, on Dask.

Each engine takes a function of a shared setup and of a part, and gives the results as
they come, in any order. A process that dies is replaced, and its parts are done again.
"""

from __future__ import annotations

import contextlib
import gc
import logging
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from rcc_sim import __version__
from rcc_sim.errors import InputError, RccError
from rcc_sim.jit import source_digest

Work = Callable[[Any, Any], Any]
Parts = Iterable[tuple[int, Any]]
Results = Iterator[tuple[int, Any]]

AHEAD = 4
"""Parts that wait for each process, so that none waits for work."""

MOST_DEATHS = 3
"""How often processes may die one after the other, and no part be done between."""

CONNECT_S = 10
"""How long to look for a scheduler. [s]"""

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

RESUMES = "what is done is kept; the same command goes on from there"


@dataclass(frozen=True)
class Engine:
    """Where to work.

    Parameters
    ----------
    jobs : int
        Processes of this machine; 1 works in this one.
    dask : str
        Address of a Dask scheduler, in place of processes.
    """

    jobs: int = 1
    dask: str = ""

    @contextlib.contextmanager
    def ready(self, work: Work, setup: Any) -> Iterator[Callable[[Parts], Results]]:
        """Give the function that does parts; all that can fail before has not.

        Raises
        ------
        InputError
            If there is no such scheduler, it has no workers, or theirs is another
            version of rccsim.
        """
        if self.jobs < 1:
            raise InputError(f"--jobs {self.jobs}: should be at least 1")
        if self.dask:
            if self.jobs > 1:
                raise InputError("--jobs and --dask: give one of them")
            with _dask(self.dask, work, setup) as done:
                yield done
        elif self.jobs > 1:
            pool = _Pool(work, setup, self.jobs)
            try:
                yield pool.done
            finally:
                pool.close()
        else:
            yield lambda parts: ((key, work(setup, part)) for key, part in parts)


def version() -> tuple[str, str]:
    """Return the version of rccsim here, and the digest of its kernel."""
    return __version__, source_digest()


# Processes of this machine

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
    """Let an interrupt wait: a process that starts meanwhile never hears of one."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # which would unblock what is blocked
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Pool:
    """A pool of processes that is built anew when one of them is killed."""

    def __init__(self, work: Work, setup: Any, jobs: int) -> None:
        self.work, self.setup, self.jobs = work, setup, jobs
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
            self.pool.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.terminate()
            for process in processes:
                process.join(timeout=5)
            self.pool.shutdown()
            self.pool = None
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
                f"is there memory for {self.jobs}? {RESUMES}",
            )
        lost = {f: item for f, item in self.waiting.items() if not _succeeded(f)}
        self.close()
        for future in lost:
            del self.waiting[future]
        for item in lost.values():
            self._give(item)


def _succeeded(future: Any) -> bool:
    return future.done() and not future.cancelled() and future.exception() is None


# A Dask cluster


@contextlib.contextmanager
def _dask(address: str, work: Work, setup: Any) -> Iterator[Callable[[Parts], Results]]:
    try:
        from dask.distributed import Client
    except ImportError:
        raise InputError(
            "--dask: dask.distributed is not installed",
            "python -m pip install 'rccsim[dask]'",
        ) from None
    for name in ("distributed", "distributed.client"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        client = Client(address, timeout=CONNECT_S)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f"--dask {address}: no scheduler there: {_first_line(error)}",
            "`dask scheduler` prints its address, as tcp://host:8786",
        ) from None
    try:
        _check_workers(client, address)
        shared = client.scatter(setup, broadcast=True, hash=False)
        yield lambda parts: _dask_done(client, work, shared, parts)
    finally:
        with contextlib.suppress(Exception):
            client.close(timeout=5)


def _check_workers(client: Any, address: str) -> None:
    """Raise unless there are workers and all have this version of rccsim."""
    if not client.scheduler_info(n_workers=-1)["workers"]:
        raise InputError(
            f"--dask {address}: the scheduler has no workers",
            f"`dask worker {address}` starts one",
        )
    found = client.run(version, on_error="return")
    for worker, theirs in found.items():
        if theirs == version():
            continue
        what = (
            f"rccsim {theirs[0]}" + ("" if theirs[0] != __version__ else ", changed")
            if isinstance(theirs, tuple)
            else f"no rccsim ({_first_line(theirs)})"
        )
        raise InputError(
            f"--dask {address}: the worker {worker} has {what}, here it is "
            f"{__version__}",
            "install the same version everywhere",
        )


def _versioned(work: Work, setup: Any, part: Any) -> Any:
    """Do a part on a worker, and say by which version."""
    return version(), work(setup, part)


def _dask_done(client: Any, work: Work, shared: Any, parts: Parts) -> Results:
    from concurrent.futures import CancelledError

    from dask.distributed import KilledWorker, wait
    from distributed.comm.core import CommClosedError

    left = iter(parts)
    waiting: dict[Any, int] = {}
    more = True
    try:
        while more or waiting:
            ahead = AHEAD * max(sum(client.nthreads().values()), 1)
            while more and len(waiting) < ahead:
                item = next(left, None)
                more = item is not None
                if item is not None:
                    future = client.submit(
                        _versioned, work, shared, item[1], pure=False, retries=3
                    )
                    waiting[future] = item[0]
            for future in wait(list(waiting), return_when="FIRST_COMPLETED").done:
                theirs, result = future.result()
                if theirs != version():
                    raise RccError(
                        f"a new worker has another rccsim: {theirs[0]}", RESUMES
                    )
                yield waiting.pop(future), result
    except KilledWorker as error:
        raise RccError(f"workers die: {_first_line(error)}", RESUMES) from None
    except (CancelledError, CommClosedError, OSError) as error:
        what = _first_line(error) or type(error).__name__
        raise RccError(f"the Dask scheduler is gone: {what}", RESUMES) from None


def _first_line(error: BaseException) -> str:
    return next(iter(str(error).strip().splitlines()), type(error).__name__)
