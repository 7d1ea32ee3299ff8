"""`rccsim` as a user runs it, in a process of its own.

Most processes are forked from one that has the modules loaded (``tests.loaded``), which
they would load for longer than most tests take. What is about the start itself, or what
the interpreter is told before it, runs ``python -m rcc_sim``.
"""

from __future__ import annotations

import multiprocessing
import os
import runpy
import sys
import tempfile
import threading
from collections.abc import Mapping
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from subprocess import CompletedProcess, TimeoutExpired

OUTPUTS = ("out", "err")
"""Files that a process writes its two streams to."""

FORKED = multiprocessing.get_context("forkserver")
FORKED.set_forkserver_preload(["tests.loaded"])


def rccsim(
    *words: object,
    cwd: str | os.PathLike[str] | None = None,
    stdin: str = "",
    env: Mapping[str, str] | None = None,
    timeout: float = 300.0,
) -> CompletedProcess[str]:
    """Run a command; return its exit code and what it wrote.

    Parameters
    ----------
    words
        What follows `rccsim`.
    cwd
        The folder that it runs in.
    stdin
        What is piped into it.
    env
        Environment variables on top of those here.
    timeout
        Time after which it is killed and the test fails. [s]
    """
    said = [*map(str, words)]
    wide = os.environ | (env or {})
    with tempfile.TemporaryDirectory() as folder:
        reads, writes = FORKED.Pipe(duplex=False)
        how = said, str(cwd or os.getcwd()), dict(wide), folder, reads
        process = FORKED.Process(target=_run, args=how)
        process.start()
        reads.close()
        threading.Thread(target=_feed, args=(writes, stdin), daemon=True).start()
        process.join(timeout)
        if process.exitcode is None:
            process.kill()
            process.join()
            raise TimeoutExpired(said, timeout)
        texts = (Path(folder, n).read_text("utf-8") for n in OUTPUTS)
        return CompletedProcess(said, process.exitcode, *texts)


def _feed(pipe: Connection, text: str) -> None:
    with suppress(BrokenPipeError), pipe, open(os.dup(pipe.fileno()), "w") as file:
        file.write(text)


def _run(
    words: list[str], cwd: str, env: dict[str, str], folder: str, stdin: Connection
) -> None:
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(env)
    out, err = (os.open(f"{folder}/{n}", os.O_WRONLY | os.O_CREAT) for n in OUTPUTS)
    for at, to in enumerate((stdin.fileno(), out, err)):
        os.dup2(to, at)
        os.close(to)
    sys.stdin = os.fdopen(0)
    sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w", buffering=1)
    sys.argv = ["rccsim", *words]
    runpy.run_module("rcc_sim", run_name="__main__", alter_sys=True)
