"""A measured efficiency map stands in place of the loss terms, in both kinds of run."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import build
from rcc_sim.simulate.run import simulate
from tests.cars import TRUCK

CYCLE = Cycle("c", np.array([0.0, 10, 30, 40]), np.array([0, 15, 15, 0.0]))


def mapped(folder, rows, **effect):
    """The pick-up with a map of these (torque, speed, efficiency) rows."""
    text = "".join(f"{t},{w},{e}\n" for t, w, e in rows)
    (folder / "map.csv").write_text("torque_nm,speed_radps,efficiency\n" + text)
    raw = TRUCK | {"effects": {"motor_efficiency": {"map": "map.csv", **effect}}}
    return build(raw, path=folder / "truck.toml")


def grid(eta, torque=2000.0, speed=2000.0):
    return [(t, w, eta(t, w)) for t in (0.0, torque) for w in (0.0, speed)]


@pytest.mark.parametrize("imposed", [False, True])
def test_a_flat_map_is_a_constant_efficiency(tmp_path, imposed):
    flat = mapped(tmp_path, grid(lambda t, w: 0.8))
    raw = TRUCK | {"effects": {"motor_efficiency": {"scale": 0.8}}}
    constant = build(raw, path=None)
    one, two = (simulate(v, CYCLE, imposed=imposed) for v in (flat, constant))
    assert one.battery_energy == pytest.approx(two.battery_energy, rel=1e-12)
    assert one.notes == two.notes == ()


def test_a_bilinear_map_costs_what_its_formula_says(tmp_path):
    """η = 0.6 + 0.1 τ/2000 + 0.2 ω/2000 is bilinear, so the map holds it exactly."""

    def eta(tau, omega):
        return 0.6 + 0.1 * tau / 2000 + 0.2 * omega / 2000

    run = simulate(mapped(tmp_path, grid(eta)), CYCLE, imposed=True)
    tau = run.trace["motor_torque_nm"][1:]
    speed = CYCLE.speed_mps
    omega = 0.5 * (speed[1:] + speed[:-1]) * 12.0 / 0.4191
    shaft, part = tau * omega, eta(np.abs(tau), omega)
    power = np.where(shaft >= 0, shaft / part, shaft * part)
    assert np.allclose(run.trace["battery_power_w"][1:], power, rtol=1e-12)


def test_beyond_its_edge_a_map_is_clamped_and_the_time_is_said(tmp_path):
    small = mapped(tmp_path, grid(lambda t, w: 0.9, torque=50.0, speed=100.0))
    run = simulate(small, CYCLE)
    assert np.isfinite(run.trace["battery_power_w"]).all()
    assert any("outside the motor's efficiency map" in note for note in run.notes)
