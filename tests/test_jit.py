"""Kernels compile once, and run where nothing can be written."""

import ast
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import rcc_sim
from rcc_sim.diagnose.noise import kernel
from rcc_sim.jit import KERNELS, compiled

RUN = """
import sys
from rcc_sim import jit
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.run import simulate
import numpy as np
said = []
jit.TELL.append(said.append)
cycle = Cycle("c", np.array([0.0, 1, 2]), np.array([0.0, 1, 0]))
run = simulate(load_vehicle("rcc"), cycle, imposed=True, engine="compiled")
print(run.battery_energy, jit.cache_folder().exists(), *said)
"""


def energy(cache):
    env = os.environ | {"RCCSIM_CACHE": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", RUN],
        capture_output=True,
        text=True,
        env=env,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_all_that_kernels_are_made_of_names_their_cache():
    package = Path(rcc_sim.__file__).parent
    known = {path for kind in KERNELS for path in package.glob(kind)}
    for path in known:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            module = getattr(node, "module", None) or ""
            if isinstance(node, ast.ImportFrom) and module.startswith("rcc_sim"):
                file = package.parent / f"{module.replace('.', '/')}.py"
                assert file in known or file.stem == "errors" or not file.exists(), (
                    f"{path.name} reads {module}"
                )


@pytest.mark.slow
def test_a_cache_that_cannot_be_written_is_done_without(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    joules, exists, *said = energy(blocked)
    assert exists == "False"
    assert " ".join(said).startswith("compiling the kernel")
    assert f"for this run alone: {blocked} cannot be written" in " ".join(said)
    assert [joules] == energy("")[:1]  # by the usual cache


def test_who_finds_the_kernels_on_disk_is_told_nothing():
    energy("")
    assert energy("")[2:] == []


def test_a_kernel_runs_without_scipy():
    env = os.environ | {"RCCSIM_CACHE": ""}
    said = RUN.replace("print(", "print('scipy.linalg' in sys.modules, ")
    done = subprocess.run(
        [sys.executable, "-c", said + "\nimport scipy.linalg"],
        capture_output=True,
        text=True,
        env=env,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[0] == "False"


def test_threads_side_by_side_keep_each_twin_in_its_own_folder(monkeypatch, tmp_path):
    """Else Python may be handed one that it cannot call, as often as it asks."""
    anew = compiled.__wrapped__
    monkeypatch.setenv("RCCSIM_CACHE", str(tmp_path))
    switching = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(8) as threads:
            ways = [False, True] * 200
            twins = threads.map(lambda x: anew(kernel.dot, inner=x), ways)
            kept = [Path(twin.stats.cache_path) for twin in twins]
    finally:
        sys.setswitchinterval(switching)
    assert [path.parent.name == "inner" for path in kept] == ways
