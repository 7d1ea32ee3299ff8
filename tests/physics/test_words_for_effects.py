"""What somebody calls an effect leads to its name."""

import pytest

from rcc_sim.physics.effect import meant
from rcc_sim.physics.effects import EFFECTS


@pytest.mark.parametrize(
    ("word", "effect"),
    [
        ("heater", "auxiliary_load"),
        ("Air drag", "aerodynamic_drag"),
        ("phase of the moon", ""),
        ("hill", "road_grade"),
        ("rolling_resistence", "rolling_resistance"),
        ("gyro bias", "yaw_rate_bias"),
        ("auxload", "auxiliary_load"),
        ("paylod", "payload"),
        ("", ""),
    ],
)
def test_a_word_for_an_effect_leads_to_it(word, effect):
    told = f"did you mean `{effect}`?" if effect else "`rccsim effects` lists them"
    assert meant(word, EFFECTS) == told


def test_a_word_for_several_effects_names_them_all():
    told = meant("bias", EFFECTS)
    assert told == "did you mean one of accelerometer_bias, yaw_rate_bias?"


def test_no_other_word_of_an_effect_is_the_name_of_one():
    """It would lead away from the effect that has it."""
    others = {word.replace(" ", "_") for e in EFFECTS.values() for word in e.also}
    assert not others & EFFECTS.keys()
