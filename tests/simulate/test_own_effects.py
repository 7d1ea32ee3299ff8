"""A user's own effects: as good as shipped ones, and told what is wrong with them."""

import pickle
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from rcc_sim.definitions import own_effects
from rcc_sim.definitions.catalogue import effect_row, effect_rows, flat_effect
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics.extra import EXTRA
from rcc_sim.simulate.run import LaneChanges, simulate
from tests.cars import car, truck

TRAILER = Path(__file__).resolve().parents[2] / "examples" / "own_effect" / "trailer.py"
CYCLE = Cycle("c", np.array([0.0, 1, 2, 3, 4]), np.array([0.0, 3, 3, 0, 0]))
BASE = {"copper_loss": {"phase_resistance_ohm": 0.02}}
EFFECT = """
from rcc_sim.physics.effect import Effect, Param

{body}

EFFECT = Effect(
    id="own", title="own", equation="own", channels=("speed_mps",), seen_as="own",
    source="own",
    params=(Param("{param}", neutral=0.0, bounds=(-9.0, 9.0), typical=(0.1, 1.0)),),
)
"""


def written(folder, body, param="size"):
    path = folder / "own.py"
    path.write_text(EFFECT.format(body=body, param=param))
    return str(path)


def with_own(vehicle, path, **params):
    return vehicle.changed(files=(path,), effects={"own": params})


TWINS = {
    "force": ("def force(size):\n    return size", {"road_load": {"a_n": 0.7}}, 0.7),
    "torque": (
        "def torque(omega, size):\n    return size * omega",
        {"drivetrain_damping": {"damping_nms_per_rad": 2e-5}},
        2e-5,
    ),
    "power": (
        "def power(size):\n    return size",
        {"auxiliary_load": {"power_w": 3.0}},
        3.0,
    ),
}


@pytest.mark.parametrize("kind", TWINS)
@pytest.mark.parametrize("imposed", [False, True])
def test_an_own_effect_does_what_the_shipped_one_of_the_same_law_does(
    kind, imposed, tmp_path
):
    body, shipped, size = TWINS[kind]
    if kind == "force":
        shipped = {"road_load": {"a_n": size, "b_n_s_per_m": 0, "c_n_s2_per_m2": 0}}
    theirs = simulate(car(BASE | shipped), CYCLE, imposed=imposed, engine="interpreted")
    made = with_own(car(BASE), written(tmp_path, body), size=size)
    ours = simulate(made, CYCLE, imposed=imposed, engine="interpreted")
    for column in ("speed_mps", "motor_current_a", "battery_power_w", "x_m"):
        scale = np.abs(theirs.trace[column]).max()
        gap = np.abs(ours.trace[column] - theirs.trace[column]).max()
        assert gap < 1e-9 * scale, column
    (sink,) = shipped
    assert ours.ledger["own"] == pytest.approx(theirs.ledger[sink], rel=1e-9)
    assert abs(ours.residual) < 1e-9


@pytest.mark.parametrize("imposed", [False, True])
def test_an_own_effect_knows_how_the_wheels_are_turned(imposed, tmp_path):
    time = np.linspace(0, 4, 81)
    drive = Cycle("c", time, np.interp(time, CYCLE.time_s, CYCLE.speed_mps))
    lanes, size = LaneChanges(3.0, length=1.5), 4.0
    how = {"imposed": imposed, "lanes": lanes, "engine": "interpreted"}
    shipped = {"steering_drag": {"force_n_per_rad": size}}
    theirs = simulate(car(BASE | shipped), drive, **how)
    body = "def force(delta, size):\n    return size * abs(delta)"
    made = with_own(car(BASE), written(tmp_path, body), size=size)
    ours = simulate(made, drive, **how)
    assert theirs.ledger["steering_drag"] > 0
    told = pytest.approx(theirs.ledger["steering_drag"], rel=1e-9)
    assert ours.ledger["own"] == told


@pytest.mark.slow
@pytest.mark.parametrize("imposed", [False, True])
def test_an_own_effect_is_compiled_to_the_same_bits(imposed):
    made = car(BASE | {"longitudinal_slip": {"stiffness_n": 300.0},
                       "rotor_inertia": {"inertia_kgm2": 2e-6}})  # fmt: skip
    made = made.changed(files=(str(TRAILER),), effects={"trailer": {"mass_kg": 0.5}})
    one, two = (
        simulate(made, CYCLE, imposed=imposed, engine=e)
        for e in ("compiled", "interpreted")
    )
    assert one.trace.columns.keys() == two.trace.columns.keys()
    assert all(np.array_equal(one.trace[c], two.trace[c]) for c in one.trace.columns)
    assert one.ledger["trailer"] > 0
    assert abs(one.residual) < 1e-9


def test_a_trailer_without_friction_is_a_heavier_car():
    effects = {"trailer": {"mass_kg": 0.5, "coefficient": 0.0}}
    pulling = car(BASE).changed(files=(str(TRAILER),), effects=effects)
    heavy = car(BASE | {"payload": {"mass_kg": 0.5}})
    a, b = (simulate(x, CYCLE, engine="interpreted") for x in (pulling, heavy))
    assert a.battery_energy == pytest.approx(b.battery_energy, rel=1e-3)
    assert np.abs(a.trace["speed_mps"] - b.trace["speed_mps"]).max() < 5e-3


def test_a_driver_and_brakes_take_an_own_force_into_account(tmp_path):
    path = written(tmp_path, "def force(v, size):\n    return 2000 * size * v / 30")
    run = simulate(with_own(truck(), path, size=1.0), CYCLE, engine="interpreted")
    assert abs(run.residual) < 1e-9
    assert run.ledger["own"] > 0
    gap = run.trace["speed_ref_mps"] - run.trace["speed_mps"]
    assert np.abs(gap).max() < 0.15


@pytest.mark.parametrize("imposed", [False, True])
def test_at_neutral_an_own_effect_leaves_every_bit(imposed, tmp_path):
    path = written(tmp_path, "def force(v, size):\n    return size * v")
    bare = simulate(car(BASE), CYCLE, imposed=imposed)
    made = with_own(car(BASE), path, size=0.0)
    run = simulate(made, CYCLE, imposed=imposed, engine="interpreted")
    assert run.trace.columns.keys() == bare.trace.columns.keys()
    assert all(np.array_equal(run.trace[c], bare.trace[c]) for c in bare.trace.columns)


def test_an_own_sensor_effect_touches_the_log_alone(tmp_path):
    body = (
        "def sensed(columns, time, size):\n"
        "    return {'speed_mps': columns['speed_mps'] + size}"
    )
    made = with_own(car(BASE), written(tmp_path, body), size=0.25)
    seen, true = simulate(made, CYCLE), simulate(car(BASE), CYCLE)
    assert np.allclose(seen.trace["speed_mps"] - true.trace["speed_mps"], 0.25)
    assert seen.ledger == true.ledger


def test_the_shipped_kernel_holds_no_hook():
    assert EXTRA is False


@pytest.mark.slow
def test_what_cannot_be_compiled_runs_in_plain_python_and_says_so(tmp_path):
    body = (
        "def force(v, size):\n"
        "    return size * sum(float(part) for part in f'{v:.3f}'.split('.')[:1])"
    )
    made = with_own(car(BASE), written(tmp_path, body), size=0.1)
    short = Cycle("c", np.array([0.0, 0.2]), np.array([2.0, 2.0]))
    run = simulate(made, short)
    assert any("plain Python" in note for note in run.notes)
    assert run.ledger["own"] > 0


@pytest.mark.slow
def test_an_own_effect_may_make_arrays(tmp_path):
    body = (
        "import numpy as np\n"
        "def force(v, size):\n"
        "    speeds = np.array([0.0, 1.0, 3.0])\n"
        "    return size * np.interp(v, speeds, speeds * speeds)"
    )
    made = with_own(car(BASE), written(tmp_path, body), size=0.2)
    one, two = (
        simulate(made, CYCLE, imposed=True, engine=e)
        for e in ("compiled", "interpreted")
    )
    assert not any("plain Python" in note for note in one.notes)
    assert one.ledger["own"] == pytest.approx(two.ledger["own"], rel=1e-12)
    assert one.ledger["own"] > 0


def test_a_vehicle_file_names_effects_that_lie_beside_it(tmp_path):
    written(tmp_path, "def force(size):\n    return size")
    (tmp_path / "mine.toml").write_text(
        '[vehicle]\nname = "mine"\nextends = "rcc"\n'
        '[effects]\nfiles = ["own.py"]\n[effects.own]\nsize = 0.5\n'
    )
    (tmp_path / "more.toml").write_text(
        '[vehicle]\nname = "more"\nextends = "mine"\n[effects.own]\nsize = 0.6\n'
    )
    mine, more = (load_vehicle(tmp_path / f"{n}.toml") for n in ("mine", "more"))
    assert mine.effects["own"]["size"].value == 0.5
    assert more.effects["own"]["size"].value == 0.6
    assert "own" in mine.known and "own" not in load_vehicle("rcc").known
    assert pickle.loads(pickle.dumps(mine)) == mine
    assert "own" not in mine.changed(without=("own",)).effects


def test_a_value_that_comes_from_elsewhere_names_the_machine_code(tmp_path):
    body = (
        "from pathlib import Path\n"
        "K = float(Path(__file__).with_name('k.txt').read_text())\n"
        "def force(size):\n    return K * size"
    )
    path = written(tmp_path, body)
    lost = []
    for value in ("0.2", "20"):
        (tmp_path / "k.txt").write_text(value)
        own_effects._of_source.cache_clear()  # as in another process
        run = simulate(with_own(car(), path, size=0.1), CYCLE, engine="compiled")
        lost.append(run.ledger["own"])
    assert lost[1] == pytest.approx(100 * lost[0], rel=0.02)


def test_an_installed_plugin_is_known_by_its_id(tmp_path, monkeypatch):
    written(tmp_path, "def force(size):\n    return size")
    monkeypatch.syspath_prepend(str(tmp_path))
    point = EntryPoint("own", "own", "rccsim.effects")
    monkeypatch.setattr("importlib.metadata.entry_points", lambda group: [point])
    made = car({"own": {"size": 0.5}})
    assert made.own["own"].where == "plugin own"
    assert simulate(made, CYCLE, engine="interpreted").ledger["own"] > 0
    assert effect_row("own")["origin"] == "plugin own"
    listed = {row["id"]: flat_effect(row) for row in effect_rows()}
    assert listed["own"]["parameters"] == "size (1)"


def test_a_plugin_that_is_not_sound_is_a_row_of_the_list_and_not_its_end(monkeypatch):
    point = EntryPoint("lost", "nowhere_at_all", "rccsim.effects")
    monkeypatch.setattr("importlib.metadata.entry_points", lambda group: [point])
    listed = {row["id"]: flat_effect(row) for row in effect_rows()}
    assert "nowhere_at_all" in listed["lost"]["title"] and "gear_loss" in listed
    with pytest.raises(InputError, match="nowhere_at_all"):
        car({"lost": {"size": 1.0}})


WRONG = {
    "should hold one function": "pass",
    "one function named force": "def force(size):\n    return 0\ndef power(size): 0",
    "no such quantity: speed": "def force(speed, size):\n    return size",
    "should take its parameter size": "def force(v):\n    return v",
    "should vanish at neutral": "def force(size):\n    return 1 + size",
    "nan at neutral": "def force(size):\n    return size * float('nan')",
    "TypeError": "def force(size):\n    return None",
    "ZeroDivisionError": "def force(size):\n    return 1 / size",
    "SyntaxError": "def force(size) return",
    "ModuleNotFoundError": "import nowhere\ndef force(size):\n    return size",
    "sensed(columns, time, size)": "def sensed(time, size):\n    return {}",
    "a column that is not there": "def sensed(columns, time, size):\n"
    "    return {'warp': time}",
    "should have 4 rows": "def sensed(columns, time, size):\n"
    "    return {'speed_mps': time[1:]}",
}


@pytest.mark.parametrize("message", WRONG)
def test_what_is_wrong_with_an_own_effect_is_said(message, tmp_path):
    path = written(tmp_path, WRONG[message])
    with pytest.raises(InputError) as caught:
        with_own(car(BASE), path, size=0.1)
    assert message in str(caught.value)
    assert str(caught.value).startswith(path)


def test_a_missing_file_and_one_without_an_effect_are_said(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        car(BASE).changed(files=(str(tmp_path / "none.py"),))
    (tmp_path / "empty.py").write_text("")
    with pytest.raises(InputError, match="EFFECT: missing"):
        car(BASE).changed(files=(str(tmp_path / "empty.py"),))
    with pytest.raises(InputError, match=r"should be a Python file"):
        car(BASE).changed(files=(str(tmp_path / "own.txt"),))


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("def force(v, size):\n    return size * (v / v if t_(v) else 1)", "raises"),
        (
            "def force(v, size):\n    return size * (1e400 if 0.5 < v < 1.5 else 1)",
            "finite",
        ),
    ],
)
@pytest.mark.parametrize(
    "engine", ["interpreted", pytest.param("compiled", marks=pytest.mark.thorough)]
)
def test_what_goes_wrong_on_the_way_stops_the_run(body, message, engine, tmp_path):
    helper = (
        "def t_(v):\n    if 1 < v < 2:\n        raise ValueError('too fast')\n"
        "    return v > 3\n"
    )
    made = with_own(car(BASE), written(tmp_path, helper + body), size=0.1)
    with pytest.raises(InputError, match=message):
        simulate(made, CYCLE, engine=engine)
