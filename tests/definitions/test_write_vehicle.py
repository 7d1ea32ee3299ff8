"""A vehicle file written anew: comments kept, figures marked, files still found."""

import shutil

import numpy as np
import pytest

from rcc_sim.analyse.logged import counted_again
from rcc_sim.definitions.faults import vehicle_faults
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.kernel import efficiency_map
from rcc_sim.definitions.library import find
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.definitions.write_vehicle import write_vehicle
from rcc_sim.errors import InputError
from rcc_sim.trace import Trace

TEXT = """\
# a car of ours
[vehicle]
name = "ours"

[body]
mass_kg = { value = 3.8, sd = 0.1 }  # weighed twice
yaw_inertia_kgm2 = 0.0382
cg_to_front_axle_m = 0.16
cg_to_rear_axle_m = 0.16

[tyres]
radius_m = 0.049
front_cornering_stiffness_n_per_rad = 90.0
rear_cornering_stiffness_n_per_rad = [80, 100]

[drivetrain]
gear_ratio = 11.82

# what it is known to have
[effects.drivetrain_damping]
damping_nms_per_rad = 1.17e-5
"""
ROLLS = {"rolling_resistance": {"coefficient": Figure(0.021, low=0.019, high=0.023)}}


@pytest.fixture
def ours(tmp_path):
    path = tmp_path / "ours.toml"
    path.write_text(TEXT)
    return path


def test_with_nothing_to_change_the_file_is_the_same(ours, tmp_path):
    out = tmp_path / "same.toml"
    write_vehicle(load_vehicle(ours), out, {}, {}, "drive.csv")
    assert out.read_text() == TEXT


def test_comments_stay_and_new_figures_name_the_log(ours, tmp_path):
    out = tmp_path / "fixed.toml"
    figures = {"body.mass_kg": Figure(3.9, sd=0.02)}
    write_vehicle(load_vehicle(ours), out, figures, ROLLS, "drive.csv")
    text = out.read_text()
    for comment in ("# a car of ours", "# weighed twice", "# what it is known to have"):
        assert comment in text
    fixed = load_vehicle(out)
    found = fixed.figures()
    assert found["body.mass_kg"].value == 3.9
    assert found["body.mass_kg"].sd == 0.02
    rolling = found["effects.rolling_resistance.coefficient"]
    assert (rolling.low, rolling.value, rolling.high) == (0.019, 0.021, 0.023)
    for key in ("body.mass_kg", "effects.rolling_resistance.coefficient"):
        assert found[key].source == "derived: drive.csv"
    before = load_vehicle(ours).figures()
    same = set(before) - {"body.mass_kg"}
    assert all(found[key] == before[key] for key in same)


def test_an_effect_that_the_file_has_is_changed_in_its_place(ours, tmp_path):
    out = tmp_path / "fixed.toml"
    damping = {"drivetrain_damping": {"damping_nms_per_rad": Figure(2e-5, sd=1e-6)}}
    write_vehicle(load_vehicle(ours), out, {}, damping, "drive.csv")
    assert out.read_text().count("[effects.drivetrain_damping]") == 1
    figure = load_vehicle(out).figures()[
        "effects.drivetrain_damping.damping_nms_per_rad"
    ]
    assert figure.value == 2e-5


def test_it_may_be_written_over_the_file_it_came_from(ours):
    write_vehicle(load_vehicle(ours), ours, {}, ROLLS, "drive.csv")
    assert "rolling_resistance" in load_vehicle(ours).effects
    assert "# weighed twice" in ours.read_text()


def test_a_vehicle_that_extends_another_still_does(tmp_path):
    shutil.copy(find("vehicles", "r1t_epa", (".toml",))[0], tmp_path / "mine.toml")
    text = (tmp_path / "mine.toml").read_text()
    (tmp_path / "mine.toml").write_text(text.replace('"r1t_epa"', '"mine"'))
    before = load_vehicle(tmp_path / "mine.toml")
    out = tmp_path / "fixed.toml"
    load = {"auxiliary_load": {"power_w": Figure(700.0, sd=20.0)}}
    write_vehicle(before, out, {}, load, "trip.csv")
    assert 'extends = "r1t"' in out.read_text()
    after = load_vehicle(out)
    assert after.figures()["effects.auxiliary_load.power_w"].value == 700.0
    key = "effects.auxiliary_load.power_w"
    old, new = before.figures(), after.figures()
    assert {k: v for k, v in new.items() if k != key} == {
        k: v for k, v in old.items() if k != key
    }


def test_a_map_is_still_found_from_another_folder(ours, tmp_path):
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "eta.csv").write_text(
        "torque_nm,speed_radps,efficiency\n0,0,0.9\n0,100,0.9\n1,0,0.9\n1,100,0.9\n"
    )
    ours.write_text(TEXT + '\n[effects.motor_efficiency]\nmap = "maps/eta.csv"\n')
    other = tmp_path / "elsewhere"
    other.mkdir()
    write_vehicle(load_vehicle(ours), other / "fixed.toml", {}, {}, "drive.csv")
    named = load_vehicle(other / "fixed.toml").effects["motor_efficiency"]["map"]
    assert (other / named).resolve() == (tmp_path / "maps" / "eta.csv").resolve()


def test_a_shipped_map_is_found_wherever_a_mended_vehicle_is_copied_to(tmp_path):
    first, second = tmp_path / "made", tmp_path / "copied"
    for folder in (first, second):
        folder.mkdir()
    shipped = load_vehicle("bmw_i3")
    write_vehicle(shipped, first / "mended.toml", {}, {}, "drive.csv")
    copy = shutil.copy(first / "mended.toml", second / "mended.toml")
    assert vehicle_faults(copy) == []
    for ours, theirs in zip(
        efficiency_map(load_vehicle(copy)), efficiency_map(shipped), strict=True
    ):
        assert (ours == theirs).all() and ours.size > 1


def test_a_map_beside_the_vehicle_goes_before_a_shipped_one(tmp_path):
    car = shutil.copy(find("vehicles", "bmw_i3", (".toml",))[0], tmp_path / "car.toml")
    (tmp_path / "bmw_i3_efficiency.csv").write_text(
        "torque_nm,speed_radps,efficiency\n0,0,0.9\n0,100,0.9\n1,0,0.9\n1,100,0.9\n"
    )
    assert efficiency_map(load_vehicle(car))[2].tolist() == [[0.9, 0.9], [0.9, 0.9]]
    car.write_text(car.read_text().replace("bmw_i3_efficiency", "no_such_map"))
    with pytest.raises(InputError, match="no_such_map"):
        efficiency_map(load_vehicle(car))


def test_a_file_with_effects_of_ones_own_is_still_found(ours, tmp_path):
    source = find("vehicles", "rcc", (".toml",))[0].parents[1]
    example = source / "examples" / "own_effect" / "trailer.py"
    if not example.is_file():
        pytest.skip("the examples are not here")
    shutil.copy(example, tmp_path / "trailer.py")
    head = '[effects]\nfiles = ["trailer.py"]\n\n'
    ours.write_text(TEXT.replace("# what it", head + "# what it"))
    other = tmp_path / "elsewhere"
    other.mkdir()
    write_vehicle(load_vehicle(ours), other / "fixed.toml", {}, ROLLS, "drive.csv")
    assert "trailer" in load_vehicle(other / "fixed.toml").own


def test_what_was_set_and_taken_out_on_the_way_is_written_too(ours, tmp_path):
    changed = load_vehicle(ours).changed(
        settings={"body.mass_kg": 4.1}, without=("drivetrain_damping",)
    )
    out = tmp_path / "fixed.toml"
    write_vehicle(changed, out, {}, {}, "drive.csv")
    assert load_vehicle(out).body.mass_kg.value == 4.1
    assert "drivetrain_damping" not in load_vehicle(out).effects


def test_a_figure_that_no_vehicle_may_have_leaves_the_file_untouched(ours, tmp_path):
    out = tmp_path / "fixed.toml"
    out.write_text("before")
    with pytest.raises(InputError, match=r"mass_kg.*nothing was written"):
        write_vehicle(
            load_vehicle(ours), out, {"body.mass_kg": Figure(-1.0)}, {}, "drive.csv"
        )
    assert out.read_text() == "before"
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".")] == []


def test_a_folder_that_is_not_there_is_named(ours, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        write_vehicle(load_vehicle(ours), tmp_path / "no" / "x.toml", {}, {}, "a")


def test_a_vehicle_that_extends_another_finds_the_files_of_that_one(tmp_path):
    """Its parent names a map beside itself, not beside the child."""
    child = tmp_path / "child.toml"
    child.write_text('[vehicle]\nname = "child"\nextends = "bmw_i3"\n')
    parent, vehicle = load_vehicle("bmw_i3"), load_vehicle(child)
    for ours, theirs in zip(
        efficiency_map(vehicle), efficiency_map(parent), strict=True
    ):
        assert (ours == theirs).all() and ours.size > 1


def test_what_was_hidden_counts_twice_and_is_told(ours, tmp_path):
    """A heater that a mended file holds, and a log of it, would be two heaters."""
    mended, again = tmp_path / "mended.toml", tmp_path / "again.toml"
    write_vehicle(load_vehicle(ours), mended, {}, ROLLS, "a.csv", ["aux_power_w"])
    write_vehicle(load_vehicle(mended), again, {}, {}, "b.csv", ["slope"])
    car = load_vehicle(again)
    assert car.vehicle.mended_without == ("aux_power_w", "slope")
    time = np.arange(0, 5, 0.1)
    log = Trace({"time_s": time, "aux_power_w": 1.0 + 0.1 * np.sin(time)}, name="log")
    (told,) = counted_again(log, car)
    assert told.channel == "aux_power_w" and "--hide aux_power_w" in told.action
    assert not counted_again(log, load_vehicle(ours))
