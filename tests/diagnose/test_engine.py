"""What the fit does with figures that do not act smoothly."""

import numpy as np
import pytest

from rcc_sim.diagnose.engine import Engine
from rcc_sim.diagnose.knobs import Knob


@pytest.mark.parametrize("x", [0.52, 8.98], ids=["inside", "beside its bound"])
def test_a_figure_that_acts_in_steps_has_a_slope_all_the_same(x):
    engine = object.__new__(Engine)  # without a log
    engine.residuals = lambda values, coarse=False: [
        -np.round(values["x"], 1) * np.arange(1.0, 9.0)
    ]
    knob = Knob("x", 0.5, low=0.0, high=9.0, step=1e-2)
    ((signal,),) = engine.signals({"x": x}, [knob])
    np.testing.assert_allclose(signal, -np.arange(1.0, 9.0))


def test_a_step_stays_between_narrow_bounds():
    tried = []

    def residuals(values, coarse=False):
        tried.append(values["x"])
        return [np.zeros(3)]

    engine = object.__new__(Engine)
    engine.residuals = residuals
    ((signal,),) = engine.signals({"x": 1.0}, [Knob("x", 1.0, low=1.0, high=1.05)])
    assert not signal.any()
    assert 1.0 <= min(tried) < max(tried) <= 1.05
