"""What a map may be told wrongly, and what is said then."""

import pytest

from rcc_sim.errors import InputError
from rcc_sim.readers.column_map import load_map, map_of


@pytest.mark.parametrize(
    ("unit", "meant"), [("Nm", "N m"), ("kmh", "km/h"), ("m/s2", "m/s^2")]
)
def test_a_unit_as_others_write_it_is_recognised_in_the_hint(tmp_path, unit, meant):
    text = f'[columns]\nmotor_torque_nm = {{ from = "T", unit = "{unit}" }}\n'
    with pytest.raises(InputError) as refused:
        map_of(text, tmp_path / "m.toml")
    assert f"did you mean {meant}?" in refused.value.hint


def test_a_shipped_map_by_half_its_name_is_recognised_in_the_hint():
    with pytest.raises(InputError, match="no such column map") as refused:
        load_map("bmw_i3")
    assert "did you mean bmw_i3_tum?" in refused.value.hint


def test_a_column_that_nothing_reads_is_told(tmp_path):
    """Misspelt it was dropped, and the log was sound."""
    told = map_of('[columns]\nsped_mps = "v"\nmy_own_v = "u"\n', tmp_path / "m.toml")
    assert told.notes == (
        "columns.sped_mps: nothing reads it; did you mean speed_mps?",
    )
