"""What every effect says of itself: columns, units, keys and believable sizes."""

from pathlib import Path

import pytest

from rcc_sim.definitions.vehicle import TABLES
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.units import SUFFIXES, unit_of

FOLDER = Path(__file__).resolve().parents[2] / "rcc_sim" / "physics" / "effects"
COLUMNS = {
    *("time_s", "speed_ref_mps", "throttle", "steer_cmd_rad", "speed_mps"),
    *("yaw_rate_radps", "accel_x_mps2", "accel_y_mps2", "motor_current_a"),
    *("motor_torque_nm", "motor_speed_radps", "current_d_a", "current_q_a"),
    *("voltage_d_v", "voltage_q_v", "battery_voltage_v", "battery_current_a"),
    *("battery_power_w", "x_m", "y_m", "yaw_rad", "elevation_m", "slope"),
    *("aux_power_w", "ambient_temperature_degc"),
}
DIMENSIONLESS = {
    *("coefficient", "efficiency", "friction_coefficient", "gain", "scale", "slope"),
    *("threshold", "share", "proportional_scale", "integral_scale"),
}


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=lambda e: e.id)
def test_an_effect_names_real_columns_units_and_keys(effect):
    assert (FOLDER / f"{effect.id}.py").is_file()
    assert effect.title and effect.equation and effect.source and effect.seen_as
    assert set(effect.channels) <= COLUMNS
    assert set(effect.excludes) <= EFFECTS.keys()
    for param in effect.params:
        low, high = param.bounds
        assert low <= param.neutral <= high or param.optional
        assert low <= param.typical[0] <= param.typical[1] <= high
        assert param.about
        with_unit = unit_of(param.name) in SUFFIXES.values()
        assert with_unit or param.name in DIMENSIONLESS
    for key in effect.needs + effect.needs_any:
        table, name, *param = key.split(".")
        fields = EFFECTS[name].neutral if param else TABLES[table].model_fields
        assert (param or [name])[0] in fields
