"""Processes killed at random moments: nothing is lost, and nothing is doubled."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time

import psutil
import pytest

RUNS = 8_000
LOGS = 150
MOST = 100
RCCSIM = (sys.executable, "-m", "rcc_sim")
COMMANDS = {
    "sweep": [
        *(*RCCSIM, "sweep", "r1t_epa", "--cycle", "udds", "--imposed"),
        *("--draw", str(RUNS // 2), "--set", "lanes.every=none,50"),
    ],
    "fleet": [*RCCSIM, "check", "logs", "--vehicle", "rcc"],
}
ENDS = {"sweep": f"{RUNS:,} runs", "fleet": f"{LOGS:,} logs"}


def written(folder):
    """Write the logs of a fleet, each with noise of its own, and one that is none."""
    from benchmarks.fleet import written

    folder.mkdir()
    list(written(folder, LOGS - 1))
    (folder / "none.csv").write_text("no log\n")


def started(command, output, jobs, **options):
    """Start a batch in a process of its own."""
    return subprocess.Popen(
        [*COMMANDS[command], "--jobs", str(jobs), "-o", str(output)],
        cwd=output.parent,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def heeding_interrupts():
    """Undo what started the tests: a shell lets what it does aside ignore them."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def parts(folder):
    """Return the bytes of every part."""
    return {path.name: path.read_bytes() for path in folder.glob("part-*")}


def workers(process):
    """Return the processes that a process has started."""
    try:
        children = psutil.Process(process.pid).children(recursive=True)
    except psutil.NoSuchProcess:
        return []
    return [c for c in children if "spawn_main" in " ".join(_words(c))]


def _words(process):
    try:
        return process.cmdline()
    except psutil.Error:
        return []


def enough(killed, many):
    """Whether so many were killed, and of each kind a third."""
    return sum(killed.values()) >= many and 3 * min(killed.values()) >= many


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="there are no such signals")
@pytest.mark.parametrize(
    ("command", "many"),
    [
        ("fleet", 2),
        *(pytest.param(c, 12, marks=pytest.mark.thorough) for c in COMMANDS),
    ],
)
def test_kills_at_random_lose_and_double_nothing(tmp_path, command, many):
    if command == "fleet":
        written(tmp_path / "logs")
    undisturbed = started(command, tmp_path / "whole", jobs=1)
    assert undisturbed.wait(timeout=120) == 0
    whole = parts(tmp_path / "whole")
    dice = random.Random(4)
    killed = {"main": 0, "worker": 0}
    out = tmp_path / "out"
    for _ in range(MOST):  # which of them a signal meets is the machine's affair
        if enough(killed, many):
            break
        process = started(command, out, jobs=2)
        before, until = len(parts(out)), time.monotonic() + 60
        while process.poll() is None and time.monotonic() < until:
            if len(parts(out)) > before:  # at work: now it may happen
                break
            time.sleep(0.005)
        time.sleep(dice.random() * 0.1)
        for _ in range(2):
            found = workers(process)
            if found and dice.random() < 0.6:
                with_worker = dice.choice(found)
                with_worker.send_signal(signal.SIGKILL)
                killed["worker"] += 1
                time.sleep(dice.random() * 0.2)
        orphans = workers(process)
        if process.poll() is None:
            process.send_signal(signal.SIGKILL)
            killed["main"] += 1
        process.wait()
        _, alive = psutil.wait_procs(orphans, timeout=10)
        assert not alive  # none goes on without its main process
        done = parts(out)
        assert all(done[name] == whole[name] for name in done)
        if len(done) == len(whole):
            if not enough(killed, many):
                for name in list(done)[::2]:  # there is more to lose
                    (out / name).unlink()
    else:
        pytest.fail(f"of {MOST} runs too few could be killed: {killed}")
    last = started(command, out, jobs=2)
    _, errors = last.communicate(timeout=120)
    assert last.returncode == 0, errors
    assert parts(out) == whole
    assert ENDS[command] in errors


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="there are no such signals")
def test_an_interrupt_as_processes_start_says_so_and_no_more(tmp_path):
    """A terminal sends it to all of them, whatever they are at."""
    undisturbed = subprocess.Popen([*RCCSIM, "cycles"], stdout=subprocess.DEVNULL)
    begun = time.monotonic()
    undisturbed.wait()
    start = time.monotonic() - begun
    for later in (0.3, 0.7, 1.1):
        process = started(
            "sweep",
            tmp_path / "out",
            jobs=2,
            start_new_session=True,
            preexec_fn=heeding_interrupts,
        )
        time.sleep(start + later)
        os.killpg(process.pid, signal.SIGINT)
        said = process.communicate(timeout=60)[1]
        assert process.returncode == 130, said
        assert said.splitlines()[-1] == "interrupted"
        assert "Traceback" not in said and "leaked" not in said
