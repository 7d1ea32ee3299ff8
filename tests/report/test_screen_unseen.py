"""What would not show is told with the size from which on it would."""

import pytest

from rcc_sim.report.screen import _from


@pytest.mark.parametrize(
    ("least", "told"),
    [
        ({"mass_kg": 0.294}, " (mass_kg from 0.29)"),
        ({"max_torque_nm": 21.0}, " (max_torque_nm up to 21)"),
        ({"hysteresis_torque_nm": None, "eddy_nms_per_rad": 2e-5}, None),
        ({"resistance_ohm": None}, ""),
        ({}, ""),
    ],
)
def test_a_size_is_told_where_any_would_show(least, told):
    found = _from(least)
    assert found == told if told is not None else "eddy_nms_per_rad" in found
