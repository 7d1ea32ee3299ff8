"""An energy report says what it does not know."""

import numpy as np
import pytest

from rcc_sim.analyse.energy import compared, energy_report, kinds_of_driving
from rcc_sim.errors import InputError
from rcc_sim.report.energy_page import regime_spans
from rcc_sim.trace import Trace

T = np.arange(0.0, 60.0, 0.5)
V = np.clip(np.minimum(T - 5.0, 50.0 - T), 0.0, 10.0)


def measured(power=200.0, **columns):
    own = {"speed_mps": V, "battery_power_w": np.full(len(T), power)}
    return Trace({"time_s": T, **own, **columns}, name="drive")


def test_a_way_with_a_gap_is_refused_by_its_row():
    way = np.cumsum(V) * 0.5
    assert energy_report(measured(distance_m=way)).wh_per_km > 0
    way[-1] = np.nan
    with pytest.raises(InputError, match="drive: distance_m, row 120: missing"):
        energy_report(measured(distance_m=way))


@pytest.mark.parametrize("column", ["battery_power_w", "speed_mps"])
def test_an_infinite_reading_is_refused_by_its_row(column):
    values = measured()[column].copy()
    values[4] = np.inf
    with pytest.raises(InputError, match=r"drive: .*, row 5: inf \(1 of 120 rows\)"):
        energy_report(measured(**{column: values}))


def test_steps_whose_speed_is_not_known_are_of_no_kind():
    speed = V.copy()
    speed[40] = np.nan
    log = measured(distance_m=np.cumsum(V) * 0.5, speed_mps=speed)
    kinds = kinds_of_driving(log)
    assert set(np.flatnonzero(kinds < 0)) == {39, 40}
    known = sum(r.time_s for r in energy_report(log).regimes)
    assert known == pytest.approx(T[-1] - 2 * 0.5)
    assert {span.name for span in regime_spans(log)} <= {
        "standstill", "acceleration", "cruise", "deceleration", "speed unknown",
    }  # fmt: skip


def test_a_change_is_a_share_of_the_size_of_what_was_first():
    """2 W h recovered where 1 W h was: 100 % less was taken."""
    reports = [energy_report(measured(p)) for p in (-1.0, -2.0)]
    assert compared(reports)[0]["energy_percent"] == pytest.approx(-100.0)
