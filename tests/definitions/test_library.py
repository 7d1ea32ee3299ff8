"""The search order of vehicles and cycles."""

import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from rcc_sim.definitions import library
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError

CSV = (".csv", ".csv.gz")
ROOT = Path(__file__).parents[2]


@pytest.fixture
def places(tmp_path, monkeypatch):
    """An empty working folder, user folder, plugin folder and shipped folder."""
    roots = {name: tmp_path / name for name in ("work", "home", "plug", "package")}
    for name, root in roots.items():
        (root if name == "plug" else root / "cycles").mkdir(parents=True)
    (roots["package"] / "inner").mkdir()
    monkeypatch.chdir(roots["work"])
    monkeypatch.setenv(library.HOME_VARIABLE, str(roots["home"]))
    monkeypatch.setattr(library, "PACKAGE", roots["package"] / "inner")
    monkeypatch.syspath_prepend(str(roots["plug"]))
    return {
        "working folder": roots["work"] / "cycles",
        "user folder": roots["home"] / "cycles",
        "plugin": roots["plug"],
        "shipped": roots["package"] / "cycles",
    }


@pytest.fixture
def plugin(places, monkeypatch):
    """Installs an entry point on the spot; returns the function that does it."""

    def install(value, name="lab"):
        point = EntryPoint(name, value, "rccsim.cycles")
        monkeypatch.setattr("importlib.metadata.entry_points", lambda group: [point])

    install("lab_cycles")
    package = places["plugin"] / "lab_cycles"
    package.mkdir()
    (package / "__init__.py").write_text("raise RuntimeError('imported')\n")
    places["plugin lab"] = package
    return install


def test_the_first_place_in_the_order_wins_and_says_what_it_shadows(places, plugin):
    order = ["working folder", "user folder", "plugin lab", "shipped"]
    for origin in order:
        (places[origin] / "a.csv").touch()
    for done, origin in enumerate(order):
        path, found = library.find("cycles", "a", CSV)
        assert found == origin
        assert path.resolve() == places[origin] / "a.csv"
        (entry,) = library.names("cycles", CSV)
        assert (entry.origin, entry.shadows) == (origin, tuple(order[done + 1 :]))
        (places[origin] / "a.csv").unlink()
    with pytest.raises(InputError, match="no such cycle: 'a'"):
        library.find("cycles", "a", CSV)


def test_plugins_are_not_asked_for_what_an_earlier_folder_has(places, monkeypatch):
    def asked(group):
        raise AssertionError("plugins were asked")

    monkeypatch.setattr("importlib.metadata.entry_points", asked)
    (places["user folder"] / "a.csv.gz").touch()
    assert library.find("cycles", "a", CSV).origin == "user folder"


@pytest.mark.parametrize(
    ("value", "file"),
    [
        ("lab_cycles", "lab_cycles/a.csv"),
        ("lab_cycles.data", "lab_cycles/data/a.csv"),
        ("lab_cycles.where", "lab_cycles/a.csv"),
        ("lab_module", "a.csv"),
    ],
)
def test_a_plugin_names_a_package_or_module_that_is_not_imported(
    value, file, places, plugin
):
    plugin(value)
    root = places["plugin"]
    (root / "lab_cycles" / "data").mkdir()
    (root / "lab_cycles" / "where.py").write_text("raise RuntimeError\n")
    (root / "lab_module.py").write_text("raise RuntimeError\n")
    (root / file).touch()
    assert library.find("cycles", "a", CSV) == (root / file, "plugin lab")


def test_a_plugin_that_names_nothing_is_an_input_error(plugin):
    for value in ("no_such_package_at_all", "lab_cycles.nothing"):
        plugin(value)
        with pytest.raises(InputError, match=f"plugin lab: .*{value}"):
            library.folders("cycles")


def test_an_unknown_name_is_an_error_that_lists_what_there_is(places):
    for name in ("udds.csv", "hwfet.csv.gz", ".hidden.csv", "notes.txt"):
        (places["shipped"] / name).touch()
    with pytest.raises(InputError, match="no such cycle: 'uds'") as error:
        library.find("cycles", "uds", CSV)
    assert error.value.hint.startswith("did you mean `udds`? there are hwfet, udds;")


def test_an_unknown_name_with_no_folder_at_all_says_so(places):
    with pytest.raises(InputError, match="no such vehicle: 'rcc'") as error:
        library.find("vehicles", "rcc", (".toml",))
    assert "none was found" in error.value.hint


def test_a_path_is_taken_as_it_is_and_never_looked_up(places):
    (places["shipped"] / "a.csv").touch()
    assert (
        library.find("cycles", str(places["shipped"] / "a.csv"), CSV).origin == "path"
    )
    with pytest.raises(InputError, match=r"^a\.csv: no such file"):
        library.find("cycles", "a.csv", CSV)
    with pytest.raises(InputError, match="it is a folder"):
        library.find("cycles", "./cycles", CSV)


def test_a_path_without_its_ending_is_answered_with_it(places):
    there = places["shipped"] / "van.toml"
    there.touch()
    with pytest.raises(InputError, match="no such file") as error:
        library.find("vehicles", str(there.with_suffix("")), (".toml",))
    assert error.value.hint == f"did you mean `{there}`?"


def test_a_working_folder_that_is_the_shipped_one_is_listed_once(places, monkeypatch):
    monkeypatch.chdir(places["shipped"].parent)
    (places["shipped"] / "a.csv").touch()
    (entry,) = library.names("cycles", CSV)
    assert (entry.origin, entry.shadows) == ("shipped", ())


def test_a_wheel_takes_its_own_folder_before_what_lies_beside_it(places):
    inside = library.PACKAGE / "_shipped" / "cycles"
    inside.mkdir(parents=True)
    (inside / "b.csv").touch()
    (places["shipped"] / "a.csv").touch()
    assert [entry.name for entry in library.names("cycles", CSV)] == ["b"]


def test_notes_that_are_no_toml_are_an_input_error(tmp_path):
    (tmp_path / "cycles.toml").write_text("[a\n")
    with pytest.raises(InputError, match=r"cycles\.toml: should be a TOML file"):
        library.notes("cycles", tmp_path / "a.csv", "a")
    assert library.notes("vehicles", tmp_path / "a.toml", "a") == {}


def test_the_library_starts_without_numpy_or_pandas():
    code = (
        "import sys, rcc_sim.definitions.library as library\n"
        "library.names('vehicles', ('.toml',))\n"
        "sys.exit(bool({'numpy', 'pandas'} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False)
    assert done.returncode == 0


@pytest.mark.parametrize("asked", ["rivian_r1t", "R1T EPA", "r1t-epa", "rivian"])
def test_a_name_that_shares_a_word_is_asked_about(asked):
    with pytest.raises(InputError) as caught:
        load_vehicle(asked)
    assert "did you mean `r1t" in caught.value.hint


@pytest.mark.parametrize(
    ("line", "mend"),
    [
        ("mass_kg = 3,78", "3.78"),
        ("mass_kg = { value = -3,78, sd = 1 }", "-3.78"),
        ("mass_kg = .5", "0.5"),
        ("mass_kg = 3.78 kg", "a number alone"),
        ("name = rcc", '"rcc"'),
        ('name = "rcc', "a quote at the end"),
        ("[body", "a bracket at the end"),
        ("mass_kg: 3.78", "mass_kg = 3.78"),
    ],
)
def test_a_slip_of_toml_is_told_with_its_mend(tmp_path, line, mend):
    path = tmp_path / "mine.toml"
    path.write_text(f"[vehicle]\n{line}\n")
    with pytest.raises(InputError) as caught:
        load_vehicle(path)
    assert "not TOML" in str(caught.value) and mend in caught.value.hint


@pytest.mark.parametrize(
    ("tables", "told", "mend"),
    [
        ('extends = "rrc"', "vehicle.extends: no such vehicle: 'rrc'", "`rcc`"),
        (
            'extends = "rcc"\n[effects]\nwithout = "copper_loss"',
            "effects.without: should be a list",
            '["copper_loss"]',
        ),
        (
            'extends = "rcc"\n[effects]\nwithout = ["copper_los"]',
            "effects.without: rcc does not have copper_los",
            "`copper_loss`",
        ),
        (
            'extends = "rcc"\n[rolling_resistance]\ncoefficient = 0.02',
            "rolling_resistance: no such key",
            "[effects.rolling_resistance]",
        ),
    ],
)
def test_what_a_file_says_of_other_names_is_told_with_its_mend(
    tmp_path, tables, told, mend
):
    path = tmp_path / "mine.toml"
    path.write_text(f'[vehicle]\nname = "mine"\n{tables}\n')
    with pytest.raises(InputError) as caught:
        load_vehicle(path)
    assert told in str(caught.value) and mend in caught.value.hint


@pytest.mark.parametrize(
    ("setting", "mend"),
    [
        ("effects.battery_resistance.resistance_ohm", "30 mOhm would be 0.03"),
        ("controller.max_steer_rad", "30 degrees would be 0.524"),
        ("effects.rolling_resistance.coefficient", "30 % would be 0.3"),
    ],
)
def test_a_number_out_of_bounds_is_told_what_it_would_be(setting, mend):
    with pytest.raises(InputError) as caught:
        load_vehicle("rcc").changed(settings={setting: 30.0})
    assert caught.value.hint == mend


def test_a_file_of_the_vehicles_folder_is_asked_about(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("vehicles").mkdir()
    Path("vehicles", "mine.toml").write_text("[vehicle]\n")
    with pytest.raises(InputError) as caught:
        load_vehicle("mine.toml")
    assert "`vehicles/mine.toml`" in caught.value.hint
