"""Intervals and indices against closed forms: energies that are linear in figures."""

from __future__ import annotations

import numpy as np
import pytest

from rcc_sim.analyse.energy import energy_report
from rcc_sim.batch.plan import Axis
from rcc_sim.batch.runs import Manoeuvre
from rcc_sim.batch.sobol import sobol_indices
from rcc_sim.batch.uncertain import drawn_energy, drawn_run, paired_change
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.figure import Z_90
from rcc_sim.errors import InputError
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace
from rcc_sim.units import J_PER_WH, G
from tests.cars import truck

DRIVE = parse_cycle("udds[20:125]")
IMPOSED = Manoeuvre(imposed=True)
ROLLING = {"value": 0.01, "sd": 0.001}
DRAG = {"value": 1.1, "sd": 0.1}
AUX = {"value": 900.0, "sd": 100.0}


def unsure(**effects):
    """Return a truck whose effects are unsure, and nothing else."""
    return truck({"copper_loss": {"phase_resistance_ohm": 0.0}, **effects})


def test_an_unsure_auxiliary_load_gives_the_interval_of_its_time():
    vehicle = unsure(auxiliary_load={"power_w": AUX})
    found = drawn_run(vehicle, DRIVE, IMPOSED, 4000)
    energy = found.spreads["energy_wh"]
    sd = 100.0 * DRIVE.duration / J_PER_WH
    assert energy.sd == pytest.approx(sd, rel=0.01)
    assert energy.high - energy.value == pytest.approx(Z_90 * sd, rel=0.02)
    assert energy.value - energy.low == pytest.approx(Z_90 * sd, rel=0.02)
    assert found.spreads["distance_m"].sd < 1e-9
    assert (found.count, found.failed) == (4000, 0)


@pytest.mark.parametrize("imposed", [True, False], ids=["imposed", "commanded"])
def test_the_figures_stated_are_those_of_a_single_run(imposed):
    vehicle = unsure(auxiliary_load={"power_w": AUX})
    found = drawn_run(vehicle, DRIVE, Manoeuvre(imposed=imposed), 10)
    run = simulate(vehicle, DRIVE, imposed=imposed, engine="compiled")
    report = energy_report(run.trace)
    assert found.spreads["energy_wh"].value == pytest.approx(report.energy_wh)
    assert found.spreads["wh_per_km"].value == pytest.approx(report.wh_per_km)


def test_a_trace_gets_the_interval_of_the_run_that_made_it():
    vehicle = unsure(auxiliary_load={"power_w": AUX})
    trace = simulate(vehicle, DRIVE, imposed=True).trace
    report = energy_report(trace)
    found = drawn_energy(vehicle, trace, report, 500)
    own = drawn_run(vehicle, DRIVE, IMPOSED, 500).spreads
    for name in ("energy_wh", "wh_per_km", "energy_auxiliary_load_wh"):
        assert found.spreads[name].value == pytest.approx(own[name].value)
        assert found.spreads[name].sd == pytest.approx(own[name].sd, rel=0.05)
    reach = found.spreads["range_km"]
    stated = 400.0 * 330.0 / report.wh_per_km
    assert reach.value == pytest.approx(stated)
    assert reach.low < stated < reach.high


def test_a_range_is_as_unsure_as_the_voltage_by_which_its_battery_is_told():
    """5 % of an open-circuit voltage are 5 % of the energy of a full battery."""
    volts = {"value": 400.0, "sd": 20.0}
    load = {"auxiliary_load": {"power_w": 900.0}}
    vehicle = truck(load, battery__open_circuit_voltage_v=volts)
    trace = simulate(vehicle, DRIVE, imposed=True).trace
    report = energy_report(trace)
    reach = drawn_energy(vehicle, trace, report, 2000).spreads["range_km"]
    assert reach.sd == pytest.approx(0.05 * reach.value, rel=0.1)


def test_a_measured_trace_has_no_interval_of_a_file():
    time = np.arange(10.0)
    log = Trace({"time_s": time, "speed_mps": time, "battery_power_w": time})
    vehicle = unsure(auxiliary_load={"power_w": AUX})
    with pytest.raises(InputError, match="does not hang on the vehicle"):
        drawn_energy(vehicle, log, energy_report(log), 10)


def test_sobol_indices_of_a_linear_energy_are_the_shares_of_its_variance():
    pytest.importorskip("SALib")
    v = DRIVE.speed_mps
    dt = np.diff(DRIVE.time_s)
    middle = 0.5 * (v[1:] + v[:-1])
    m = truck().body.mass_kg.value
    by_sd = {
        "effects.auxiliary_load.power_w": 100.0 * DRIVE.duration,
        "effects.rolling_resistance.coefficient": 0.001 * m * G * (middle * dt).sum(),
        "effects.aerodynamic_drag.drag_area_m2": 0.1 * 0.6 * (middle**3 * dt).sum(),
    }
    whole = sum(value**2 for value in by_sd.values())
    vehicle = unsure(
        auxiliary_load={"power_w": AUX},
        rolling_resistance={"coefficient": ROLLING},
        aerodynamic_drag={"drag_area_m2": DRAG},
    )
    rows = sobol_indices(vehicle, DRIVE, IMPOSED, samples=4096)
    assert {row["key"] for row in rows} == set(by_sd)
    for row in rows:
        share = by_sd[row["key"]] ** 2 / whole
        assert row["first_order"] == pytest.approx(share, abs=0.03)
        assert row["total"] == pytest.approx(share, abs=0.03)


def test_a_range_that_is_given_by_hand_is_varied_evenly():
    pytest.importorskip("SALib")
    vehicle = unsure(auxiliary_load={"power_w": AUX})
    low, high = 600.0, 1200.0
    ranges = {
        "effects.auxiliary_load.power_w": (low, high),
        "effects.rolling_resistance.coefficient": (0.0, 1e-9),
    }
    rows = sobol_indices(vehicle, DRIVE, IMPOSED, samples=256, ranges=ranges)
    assert rows[0]["key"] == "effects.auxiliary_load.power_w"
    assert rows[0]["total"] == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"samples": 0}, "--samples: should lie between"),
        ({"samples": 10**9}, "--samples: should lie between"),
        ({"samples": 4, "of": ["wh_per_mile"]}, "no such figure"),
        ({"samples": 4, "of": ["distance_m"]}, "does not depend on any"),
        ({"samples": 4, "ranges": {"body.mas_kg": (1, 2)}}, "no such key"),
    ],
)
def test_indices_that_cannot_be_are_refused(options, words):
    pytest.importorskip("SALib")
    vehicle = unsure(auxiliary_load={"power_w": AUX})
    with pytest.raises(InputError, match=words):
        sobol_indices(vehicle, DRIVE, IMPOSED, **options)


def test_what_lane_changes_cost_is_surer_in_pairs_than_apart():
    fine = np.arange(0.0, DRIVE.duration, 0.1)
    cycle = Cycle("fine", fine, np.interp(fine, DRIVE.time_s, DRIVE.speed_mps))
    vehicle = unsure(
        auxiliary_load={"power_w": AUX}, rolling_resistance={"coefficient": ROLLING}
    )
    axis = Axis("lanes.every", (float("inf"), 50.0))
    row = paired_change(vehicle, cycle, IMPOSED, axis, 300)[0]
    runs = [
        energy_report(simulate(vehicle, cycle, imposed=True, lanes=lanes).trace)
        for lanes in (None, LaneChanges(50.0))
    ]
    cost = 100 * (runs[1].wh_per_km / runs[0].wh_per_km - 1)
    assert row["wh_per_km_percent"] == pytest.approx(cost)
    assert row["low"] < cost < row["high"]
    apart = 100 * (row["wh_per_km_high"] / row["wh_per_km_low"] - 1)
    assert row["high"] - row["low"] < 0.5 * apart
