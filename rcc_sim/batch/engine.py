"""Where the parts of a batch are done: here, in processes of this machine, on Dask.

Each engine takes a function of a shared setup and of a part, and gives the results as
they come, in any order.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from rcc_sim import __version__
from rcc_sim.errors import InputError, RccError
from rcc_sim.jit import source_digest
from rcc_sim.processes import AHEAD, Parts, Results, Work, working

CONNECT_S = 10
"""How long to look for a scheduler. [s]"""

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
        if self.dask and self.jobs > 1:
            raise InputError("--jobs and --dask: give one of them")
        here = working(work, setup, self.jobs, RESUMES)
        with _dask(self.dask, work, setup) if self.dask else here as done:
            yield done


def version() -> tuple[str, str]:
    """Return the version of rccsim here, and the digest of its kernel."""
    return __version__, source_digest()


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
