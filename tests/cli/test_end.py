"""A command ends its process at once: nothing takes the interpreter down any more."""

import subprocess
import sys

import pytest

ENDS = """
import atexit, sys
from rcc_sim.cli.app import main
atexit.register(print, "taken down")
sys.argv = ["rccsim", *sys.argv[1:]]
main()
"""


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--version"], 0, "rccsim "),
        (["vehicles"], 0, "twizy"),
        (["vehicles", "show", "rc"], 2, "no such vehicle"),
    ],
)
def test_what_was_written_is_there_and_no_thread_can_abort_it(words, code, said):
    """A thread of a CSV reader did so, after a conversion that had gone well."""
    ended = subprocess.run(
        [sys.executable, "-c", ENDS, *words], capture_output=True, text=True
    )
    assert ended.returncode == code
    assert said in ended.stdout + ended.stderr
    assert "taken down" not in ended.stdout


def test_a_pipe_gets_all_of_a_long_table():
    """What is buffered is flushed before the end."""
    words = ["-m", "rcc_sim", "simulate", "rcc", "--cycle", "udds[20:60]"]
    table = subprocess.run([sys.executable, *words], capture_output=True, text=True)
    assert table.returncode == 0
    lines = table.stdout.splitlines()
    fields = {line.count(",") for line in lines}
    assert len(lines) > 1000 and len(fields) == 1
    assert table.stdout.endswith("\n")


LOADS = """
import os, signal
from rcc_sim.cli import app

def loading():
    try:
        if {interrupted}:
            os.kill(os.getpid(), signal.SIGINT)
    except KeyboardInterrupt:
        pass
    raise ImportError("initialization failed")  # as CPython says of a module in C

app._run = loading
app.main()
"""


@pytest.mark.parametrize(("interrupted", "code"), [(True, 130), (False, 1)])
def test_an_interrupt_that_meets_a_module_being_loaded_is_one(interrupted, code):
    program = LOADS.format(interrupted=interrupted)
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True)
    assert ended.returncode == code
    assert (ended.stderr == b"interrupted\n") is interrupted
