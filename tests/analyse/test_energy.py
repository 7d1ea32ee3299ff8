"""An energy report says what it does not know."""

import numpy as np
import pytest

from rcc_sim.analyse.energy import (
    compared,
    energy_report,
    kinds_of_driving,
    scaled_trace,
)
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.report.energy_page import regime_spans
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

T = np.arange(0.0, 60.0, 0.5)
V = np.clip(np.minimum(T - 5.0, 50.0 - T), 0.0, 10.0)


def measured(power=200.0, **columns):
    own = {"speed_mps": V, "battery_power_w": np.broadcast_to(power, len(T))}
    return Trace({"time_s": T, **own, **columns}, name="drive")


def test_a_way_with_a_gap_is_refused_by_its_row():
    way = np.cumsum(V) * 0.5
    assert energy_report(measured(distance_m=way)).wh_per_km > 0
    way[-1] = np.nan
    with pytest.raises(InputError, match="drive: distance_m, row 120: missing"):
        energy_report(measured(distance_m=way))


def test_rows_without_a_reading_are_bridged_and_counted():
    power = 200.0 + 3.0 * T
    lost = power.copy()
    lost[[7, 30, 31, 90]] = np.nan
    report = energy_report(measured(lost))
    assert report.energy_wh == pytest.approx(energy_report(measured(power)).energy_wh)
    assert report.bridged == 4


@pytest.mark.parametrize(
    ("lost", "row"), [(slice(20, 40), 21), (slice(0, 1), 1), (slice(1, None), 2)]
)
def test_a_long_hole_and_a_missing_end_are_refused_by_their_row(lost, row):
    power = np.full(len(T), 200.0)
    power[lost] = np.nan
    with pytest.raises(InputError, match=f"drive: battery power, row {row}: missing"):
        energy_report(measured(power))


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


@pytest.mark.parametrize("told", ["power", "volts and amperes", "ledger"])
def test_a_drive_at_another_size_is_the_scaled_one_in_every_row(told):
    run = simulate(load_vehicle("rcc"), Cycle("c", T / 4, V / 4)).trace
    energy = {
        "ledger": [c for c in run.columns if c.endswith("_j")],
        "power": ["battery_power_w"],
        "volts and amperes": ["battery_voltage_v", "battery_current_a"],
    }[told]
    small = Trace({c: run[c] for c in ("time_s", "speed_mps", "distance_m", *energy)})
    large = scaled_trace(small, "rcc", "r1t")
    car, truck = load_vehicle("rcc").figures(), load_vehicle("r1t").figures()
    m, force = (
        truck[k].value / car[k].value
        for k in ("body.mass_kg", "tyres.front_cornering_stiffness_n_per_rad")
    )
    length = load_vehicle("r1t").wheelbase / load_vehicle("rcc").wheelbase
    mine, others = energy_report(small), energy_report(large)
    assert others.energy_wh == pytest.approx(mine.energy_wh * force * length)
    assert others.duration_s == pytest.approx(
        mine.duration_s * (m * length / force) ** 0.5
    )
    assert large["speed_mps"] == pytest.approx(
        small["speed_mps"] * (force * length / m) ** 0.5
    )
    assert large["distance_m"] == pytest.approx(small["distance_m"] * length)
    assert [r.name for r in others.regimes] == [r.name for r in mine.regimes]


def test_a_change_is_a_share_of_the_size_of_what_was_first():
    """2 W h recovered where 1 W h was: 100 % less was taken."""
    reports = [energy_report(measured(p)) for p in (-1.0, -2.0)]
    assert compared(reports)[0]["energy_percent"] == pytest.approx(-100.0)
