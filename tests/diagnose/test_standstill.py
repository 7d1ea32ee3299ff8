"""What a motor does while its vehicle stands: nothing, or what no motion tells."""

import numpy as np
import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace, write_trace
from tests.cars import truck

EVS = ("bmw_i3", "r1t", "r1t_epa", "tesla_model_3", "twizy")
STOPS = Cycle("stops", np.array([0.0, 5, 15, 25, 35]), np.array([0.0, 0, 8, 0, 0]))


def opened(trace, path, vehicle):
    with path.open("wb") as file:
        write_trace(trace, file)
    return open_log(path, vehicle)


@pytest.mark.parametrize("effects", [{}, {"copper_loss": {"phase_resistance_ohm": 1}}])
def test_the_brakes_hold_what_stands_and_the_motor_takes_nothing(effects):
    run = simulate(truck(effects), STOPS).trace
    rests = (run["time_s"] > 27) & (run["speed_mps"] == 0)
    assert rests.sum() > 50
    assert (run["motor_torque_nm"][rests] == 0).all()
    assert (run["battery_power_w"][rests] == 0).all()


def test_the_brakes_hold_it_on_a_hill_too():
    for slope in (-0.05, 0.05):
        run = simulate(truck({"road_grade": {"slope": slope}}), STOPS).trace
        late = run["time_s"] > 28
        assert (run["speed_mps"][late] == 0).all()
        assert (run["motor_torque_nm"][late] == 0).all()


@pytest.mark.parametrize("name", EVS)
def test_the_motion_imposed_asks_for_what_the_driver_asked(name, tmp_path):
    """Two ways through the equations of motion: forwards, and backwards."""
    vehicle = load_vehicle(name)
    run = simulate(vehicle, parse_cycle("udds[0:340]")).trace
    found = gap(opened(run, tmp_path / "log.csv", vehicle), vehicle)
    assert found.mode == "imposed"
    assert abs(found.energy.gap_percent) < 0.01
    for channel in found.channels:
        size = float(np.max(np.abs(run[channel.channel])))
        assert channel.rmse <= 1e-3 * size, channel


def creeping(trace):
    """The same log of a motor that pushes against the brakes at rest."""
    torque = np.where(trace["speed_mps"] == 0, 25.0, trace["motor_torque_nm"])
    return Trace(dict(trace.columns) | {"motor_torque_nm": torque}, name=trace.name)


def test_a_motor_that_creeps_against_the_brakes_is_no_gap(tmp_path):
    vehicle = load_vehicle("bmw_i3")
    run = simulate(vehicle, parse_cycle("udds[0:340]")).trace
    log = opened(creeping(run), tmp_path / "log.csv", vehicle)
    plain = opened(run, tmp_path / "plain.csv", vehicle)
    torque = {c.channel: c.rmse for c in gap(log, vehicle).channels}["motor_torque_nm"]
    still = {c.channel: c.rmse for c in gap(plain, vehicle).channels}
    assert torque == still["motor_torque_nm"]
    assert diagnose([log], vehicle).status == "no_gap"


def test_the_energy_on_held_out_rows_is_the_gap_s_where_a_cause_acts_at_the_shaft(
    tmp_path,
):
    vehicle = load_vehicle("r1t")
    drags = {"effects.aerodynamic_drag.drag_area_m2": 1.9}
    run = simulate(vehicle.changed(settings=drags), parse_cycle("hwfet[0:300]")).trace
    found = diagnose([opened(run, tmp_path / "log.csv", vehicle)], vehicle)
    assert [a.cause.effect for a in found.asserted] == ["aerodynamic_drag"]
    assert not found.proof.by_torque
    whole = found.gaps[0].energy.gap_percent
    assert found.proof.before == pytest.approx(whole, abs=0.15 * whole)
    assert abs(found.proof.after) < 0.01 * whole


def test_it_follows_from_the_torque_where_a_cause_acts_beyond_the_shaft(tmp_path):
    vehicle = load_vehicle("tesla_model_3")
    load = {"auxiliary_load": {"power_w": 1500.0}}
    run = simulate(vehicle.changed(effects=load), parse_cycle("udds[0:340]")).trace
    found = diagnose([opened(run, tmp_path / "log.csv", vehicle)], vehicle)
    assert [a.cause.effect for a in found.asserted] == ["auxiliary_load"]
    assert (
        found.proof.by_torque
        and found.document()["shrink"]["energy_by_measured_torque"]
    )
    assert found.proof.before > 10
    assert abs(found.proof.after) < 0.1
