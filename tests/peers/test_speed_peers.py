"""What the speed benchmark times in place of the F1TENTH gym."""

import numpy as np
import pytest

from benchmarks import peers

pytest.importorskip("vehiclemodels", reason="needs commonroad-vehicle-models")
from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st
from vehiclemodels.vehicle_parameters import setup_vehicle_parameters


def test_the_compiled_single_track_is_commonroads_own():
    p = setup_vehicle_parameters(vehicle_id=2)
    rates = peers.compiled_rates(vehicle_dynamics_st, p)
    draw = np.random.default_rng(3)
    for speed in (0.05, *draw.uniform(0.2, 40.0, 20)):  # the first: their kinematics
        x = np.concatenate([draw.normal(0, 0.1, 3), [speed], draw.normal(0, 0.1, 3)])
        u = draw.normal(0.0, 1.0, 2)
        theirs = vehicle_dynamics_st(x, u, p)
        assert rates(x, u) == pytest.approx(theirs, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(("step", "order"), [(peers.euler, 1), (peers.runge_kutta, 4)])
def test_the_peers_integrators_have_their_order(step, order, monkeypatch):
    def error(dt):
        monkeypatch.setattr(peers, "DT", dt)
        x = np.array([1.0])
        for _ in range(round(1.0 / dt)):
            x = step(lambda x, u: u * x, x, np.array([-1.0]))
        return abs(x[0] - np.exp(-1.0))

    assert np.log2(error(0.1) / error(0.05)) == pytest.approx(order, abs=0.15)
