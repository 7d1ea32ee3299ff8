"""Kernels compile once, and run where nothing can be written."""

import os
import subprocess
import sys

import pytest

RUN = """
import sys
from rcc_sim import jit
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.run import simulate
import numpy as np
cycle = Cycle("c", np.array([0.0, 1, 2]), np.array([0.0, 1, 0]))
run = simulate(load_vehicle("rcc"), cycle, imposed=True, engine="compiled")
print(run.battery_energy, jit.cache_folder().exists())
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


@pytest.mark.slow
def test_a_cache_that_cannot_be_written_is_done_without(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    joules, exists = energy(blocked)
    assert exists == "False"
    assert joules == energy("")[0]  # by the usual cache


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
