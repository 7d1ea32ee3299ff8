"""A battery whose file states no resistance: how much it has is told by its voltage."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.candidates import candidates_for
from rcc_sim.diagnose.compete import compete
from rcc_sim.diagnose.engine import Engine
from rcc_sim.diagnose.posed import problem_of
from rcc_sim.trace import Trace

RESISTANCE = 0.06  # Ω
SPEED_NOISE = 0.02  # m/s; what is driven is known less well than what flows


@pytest.mark.slow
def test_a_resistance_is_found_where_the_current_is_better_known_than_the_drive():
    """Voltage is V_oc - R I to the row; the model's current jitters with the speed."""
    rng = np.random.default_rng(6)
    known = {"battery.open_circuit_voltage_v": 57.0}
    car = load_vehicle("twizy").changed(settings=known)
    t = np.arange(0.0, 400.0, 0.1)
    v = np.clip(7 + 5 * np.sin(t / 7) + 3 * np.sin(t / 2.3), 0.0, None)
    driven = problem_of(Trace({"time_s": t, "speed_mps": v}), car).run(car)
    current = driven["battery_power_w"] / driven["battery_voltage_v"]
    volts = driven["battery_voltage_v"] - RESISTANCE * current
    log = Trace(
        {
            "time_s": t,
            "speed_mps": v + SPEED_NOISE * rng.normal(size=len(t)),
            "battery_voltage_v": volts + 0.02 * rng.normal(size=len(t)),
            "battery_current_a": current + 0.2 * rng.normal(size=len(t)),
        }
    )
    problem = problem_of(log, car)
    found = compete(
        Engine([problem]), candidates_for([problem], ["battery_resistance"])
    )
    (cause,) = found.causes
    assert cause.effect == "battery_resistance"
    value = found.fit.values["effects.battery_resistance.resistance_ohm"]
    assert value == pytest.approx(RESISTANCE, rel=0.03)
