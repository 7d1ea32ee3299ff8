"""What a file states of its sensors is read, or refused."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.simulate.run import simulate

LATE = "[sensors.yaw_rate_radps]\nlatency_s = { value = 0.1, sd = 0.02 }\n"


@pytest.fixture
def file_of(tmp_path):
    def write(tables):
        path = tmp_path / "mine.toml"
        path.write_text(f'[vehicle]\nname = "mine"\nextends = "rcc"\n{tables}')
        return path

    return write


def driven(vehicle):
    t = np.arange(0.0, 20.0, 0.02)
    bends = Cycle("bends", t, np.full(len(t), 2.0))
    return simulate(vehicle, bends, steer=(t, 0.1 * np.sin(t)), output_rate=50.0).trace


def test_a_latency_delays_its_sensor(file_of):
    late, true = driven(load_vehicle(file_of(LATE))), driven(load_vehicle("rcc"))
    rows = 5  # 0.1 s
    np.testing.assert_allclose(
        late["yaw_rate_radps"][rows:], true["yaw_rate_radps"][:-rows], atol=1e-12
    )
    np.testing.assert_array_equal(late["speed_mps"], true["speed_mps"])


def test_a_latency_has_an_sd_and_can_be_taken_out(file_of):
    car = load_vehicle(file_of(LATE))
    key = "effects.sensor_delay.yaw_rate_delay_s"
    assert (car.figure(key).value, car.figure(key).sd) == (0.1, 0.02)
    without = car.changed(without=("sensor_delay",))
    assert "sensor_delay" not in without.effects
    with pytest.raises(InputError, match="does not have it"):
        without.changed(without=("sensor_delay",))


def test_what_the_effect_states_counts(file_of):
    stated = "[effects.sensor_delay]\nyaw_rate_delay_s = 0.3\nspeed_delay_s = 0.2\n"
    found = load_vehicle(file_of(LATE + stated)).effects["sensor_delay"]
    assert {k: f.value for k, f in found.items()} == {
        "yaw_rate_delay_s": 0.3,
        "speed_delay_s": 0.2,
    }


@pytest.mark.parametrize(
    ("tables", "told"),
    [
        ("[sensors.yaw_rate]\nnoise_sd = 0.1", "sensors.yaw_rate: no such key"),
        ("[sensors.x_m]\nlatency_s = 0.1", "delay of this column is not modelled"),
        ("[sensors.speed_mps]\nlatency_s = 3", "between -2 and 2"),
        ("[sensors.speed_mps]\nlatency_s = -0.1", "should be at least 0: -0.1"),
        (
            "[sensors.speed_mps]\nscale_sd = 0.1",
            "is read of motor_torque_nm, elevation_m, yaw_rate_radps, accel_x_mps2",
        ),
        (
            "[sensors.speed_mps]\nlatency_s = 0.1\n"
            "[sensors.motor_speed_radps]\nlatency_s = 0.2",
            "motor_speed_radps.latency_s: 0.2 s, and 0.1 s for speed_mps",
        ),
    ],
)
def test_what_nobody_would_read_is_refused(file_of, tables, told):
    with pytest.raises(InputError, match=told):
        load_vehicle(file_of(tables))


def test_a_name_that_only_lacks_its_unit_is_known(file_of):
    with pytest.raises(InputError) as caught:
        load_vehicle(file_of("[sensors.yaw_rate]\nnoise_sd = 0.1"))
    assert caught.value.hint == "did you mean `sensors.yaw_rate_radps`?"
