"""Motor maps balance their power; envelopes scale there and back."""

from __future__ import annotations

import io
import math

import numpy as np
import pytest
from similar import car, truck

from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.similitude.envelope import envelope_of, speed_limits
from rcc_sim.similitude.motor_map import efficiency_of_losses, motor_map
from rcc_sim.similitude.motor_plot import draw, picture_format
from rcc_sim.simulate.run import simulate


def test_the_efficiency_is_shaft_power_over_shaft_power_and_losses():
    tau, omega = 0.05, 1000.0
    turning = tau + 1.17e-5 * omega
    copper = 1.5 * 0.0195 * (turning / (1.5 * 2 * 0.887e-3)) ** 2
    eta = efficiency_of_losses(car(), np.array(turning), np.array(omega))
    assert eta == pytest.approx(tau * omega / (turning * omega + copper))
    less = efficiency_of_losses(car(), np.array(1.16e-5 * omega), np.array(omega))
    assert less == 0.0  # the drag takes it all


def test_no_point_of_a_map_takes_more_current_than_the_controller_gives():
    result = motor_map(car())
    inside = np.isfinite(result.efficiency).any(axis=1)
    current = result.torque[inside] / (1.5 * 2 * 0.887e-3)
    assert current.max() == pytest.approx(50.0)


def test_no_point_of_a_map_gains_power():
    eta = motor_map(car()).efficiency
    assert np.nanmax(eta) < 1
    assert np.nanmin(eta) >= 0


def test_an_efficiency_without_a_map_is_the_same_everywhere():
    speed = {"motor.max_speed_radps": 1500.0}
    flat = load_vehicle("tesla_model_3").changed(settings=speed)
    eta = motor_map(flat).efficiency
    assert set(eta[np.isfinite(eta)]) == {0.9}


def test_a_motor_on_itself_is_wholly_inside():
    against = motor_map(car(), car()).against
    assert against.share_inside == 1.0
    assert against.leaves == ()


def test_the_truck_asks_more_torque_than_the_cars_current_gives():
    against = motor_map(car(), truck(), top_speed=50.0).against
    lever = (0.049 / 11.82) / (0.4191 / 12)
    assert against.torque_factor == pytest.approx(90 / 40700 * lever)
    assert against.scaled.torque.value == pytest.approx(1231 * 90 / 40700 * lever)
    assert 0 < against.share_inside < 1
    assert against.leaves[0].by == "controller.max_current_a"


def test_a_driven_cycle_is_scaled_onto_the_motor():
    against = motor_map(car(), truck(), cycle=parse_cycle("udds")).against
    assert against.drive_inside == 1.0
    assert against.drive[0].max() * 0.049 / 11.82 == pytest.approx(10.54, rel=5e-3)


def test_an_envelope_scaled_there_and_back_is_the_envelope():
    own = envelope_of(car())
    back = own.scaled(3.0, 7.0).scaled(1 / 3, 1 / 7)
    omega = np.linspace(0, 3000, 50)
    assert back.torque_at(omega) == pytest.approx(own.torque_at(omega))


def test_the_voltage_takes_the_torque_near_the_no_load_speed():
    fast = car(controller={"max_electrical_speed_radps": 1e5})
    envelope = envelope_of(fast)
    assert envelope.speed.by == "battery voltage"
    assert envelope.speed.value == pytest.approx(12 / 3**0.5 / (2 * 0.887e-3))
    assert envelope.torque_at(envelope.speed.value) == pytest.approx(0)
    assert envelope.torque_at(0.0) == pytest.approx(50 * 1.5 * 2 * 0.887e-3)
    without = fast.changed(without=("drivetrain_damping",))  # nothing left to overcome
    ask = Cycle("up", np.array([0.0, 60.0, 200.0]), np.array([0.0, 20.0, 20.0]))
    reached = simulate(without, ask).trace["motor_speed_radps"].max()
    assert reached == pytest.approx(envelope.speed.value, rel=1e-3)


def test_without_a_flux_linkage_the_voltage_holds_by_the_motors_kv():
    motor = {"flux_linkage_wb": None, "velocity_constant_rpm_per_v": 3300}
    assert speed_limits(car(motor=motor))["battery voltage"] == pytest.approx(
        3300 * 12 * 2 * math.pi / 60
    )


def test_a_measured_map_is_read_where_the_vehicle_names_one(tmp_path):
    path = tmp_path / "map.csv"
    path.write_text(
        "torque_nm,speed_radps,efficiency\n"
        "0,0,0.5\n0,4000,0.5\n0.2,0,0.9\n0.2,4000,0.9\n"
    )
    vehicle = car().changed(
        without=("copper_loss",), effects={"motor_efficiency": {"map": str(path)}}
    )
    result = motor_map(vehicle, points=5)
    assert result.made_of == "measured map"
    assert result.efficiency[0] == pytest.approx(0.5)
    assert result.efficiency[-1] == pytest.approx(0.5 + 0.4 * result.torque[-1] / 0.2)


@pytest.mark.parametrize(
    ("vehicle", "key"),
    [
        (lambda: car().changed(without=("copper_loss",)), "phase_resistance_ohm"),
        (truck, "motor.max_speed_radps"),
    ],
)
def test_what_a_map_needs_is_named(vehicle, key):
    with pytest.raises(InputError, match=key):
        motor_map(vehicle())


@pytest.mark.parametrize("name", ["map.png", "map.svg", "map.pdf"])
def test_a_picture_is_drawn_in_the_format_of_its_name(name):
    result = motor_map(car(), truck(), cycle=parse_cycle("udds[0:60]"), points=9)
    file = io.BytesIO()
    draw(result, file, picture_format(name))
    assert len(file.getvalue()) > 2000


def test_a_picture_of_no_known_format_is_refused():
    with pytest.raises(InputError, match="png"):
        picture_format("map.bmp")
