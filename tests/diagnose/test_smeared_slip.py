"""A tyre's slip in a log driven by its speed: as far as the log's rows tell it."""

from math import inf

import numpy as np
import pytest

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.causes.sought import search_of
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.physics.effects.longitudinal_slip import EFFECT
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from tests.cars import car

CAR = load_vehicle("r1t_epa")
CYCLE = parse_cycle("us06[0:200]")


def search(rate, noise=0.0):
    run = simulate(CAR, CYCLE, imposed=True, output_rate=rate).trace
    rng = np.random.default_rng(2)
    log = {c: run[c] for c in ("time_s", "battery_power_w", "battery_energy_j")}
    log["speed_mps"] = np.abs(run["speed_mps"] + rng.normal(0, noise, len(run)))
    problem = problem_of(Trace(log, name="log"), CAR)
    return problem, search_of(problem, EFFECT, EFFECT.params[0])


def test_the_stiffest_that_is_told_is_ahead_by_what_is_smeared():
    problem, found = search(5.0)
    speed = np.sqrt(np.mean(problem.speed**2))
    ahead = CAR.body.mass_kg.value * speed / found.high  # s
    assert ahead == pytest.approx(2 * 0.2, rel=1e-6)
    assert found.weakest == found.high
    assert max(found.grid) <= found.high


def test_closer_rows_tell_a_stiffer_one_and_noise_a_softer_one():
    _, close = search(20.0)
    _, wide = search(5.0)
    _, noisy = search(20.0, noise=0.03)
    assert close.high == pytest.approx(4 * wide.high, rel=0.02)
    assert noisy.high < 0.5 * close.high


def test_behind_noise_it_is_sought_where_it_is_asked_for_alone():
    """A softer tyre makes any noise of the motion look like less."""
    clean, noisy = (search(20.0, noise)[0] for noise in (0.0, 0.03))
    assert EFFECT.id in {c.effect for c in candidates_for([clean])}
    assert EFFECT.id not in {c.effect for c in candidates_for([noisy])}
    assert EFFECT.id in {c.effect for c in candidates_for([noisy], [EFFECT.id])}


def test_a_drive_of_a_controller_tells_any():
    small = car({"longitudinal_slip": {"stiffness_n": 600.0}})
    run = simulate(small, parse_cycle("udds[20:60]"), output_rate=100.0).trace
    columns = {
        c: run[c] for c in ("time_s", "speed_ref_mps", "speed_mps", "motor_current_a")
    }
    problem = problem_of(Trace(columns, name="log"), car({}))
    found = search_of(problem, EFFECT, EFFECT.params[0])
    assert (found.high, found.weakest) == (inf, None)
