"""`rccsim effects`: what is printed of each effect, drawn, and converted."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from rcc_sim.definitions.catalogue import effect_row
from rcc_sim.definitions.road_load import converted, two_terms
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.physics.effects.road_load import road_load_force
from rcc_sim.report.effect_plot import SEEN, most_moved, reference_runs
from rcc_sim.simulate.run import simulate
from rcc_sim.units import G
from tests.cars import car
from tests.physics.test_effects import CYCLE
from tests.program import rccsim

OWN = Path(__file__).resolve().parents[2] / "examples" / "own_effect" / "trailer.py"


@pytest.mark.parametrize("name", EFFECTS)
def test_show_gives_all_that_is_known_of_an_effect(name):
    row = effect_row(name)
    assert row["equation"] and row["channels"] and row["source"] and row["seen_as"]
    assert row["origin"] == "shipped"
    for param in row["parameters"]:
        assert {"unit", "neutral", "low", "high", "typical_low", "typical_high"} <= set(
            param
        )


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=lambda e: e.id)
def test_a_fit_finds_a_finite_range_to_look_in(effect):
    for param in effect.params:
        low, high = param.search
        assert math.isfinite(low) and math.isfinite(high)
        assert param.bounds[0] <= low < high <= param.bounds[1]
        assert low <= param.typical[0] < param.typical[1] <= high
        assert low <= param.neutral <= high or math.isinf(param.neutral)


@pytest.mark.parametrize("name", EFFECTS)
def test_the_reference_drive_shows_each_effect_in_a_channel_that_it_names(name):
    effect = EFFECTS[name]
    _, off, on = reference_runs(name, effect)
    shown = most_moved(effect, off, on)
    own = [column for column in shown if column in effect.channels]
    assert own
    moved = [
        np.abs(on[column] - off[column]).max() / max(np.ptp(off[column]), 1e-9)
        for column in own
    ]
    assert max(moved) > SEEN


def test_show_draws_shipped_and_own_effects(tmp_path):
    for k, name in enumerate(["gear_loss", OWN]):
        done = rccsim("effects", "show", name, "--plot", f"{k}.svg", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert "<svg" in (tmp_path / f"{k}.svg").read_text()
    assert f"origin,{OWN}" in done.stdout
    done = rccsim("effects", "show", "gear_loss", "--plot", "x.txt", cwd=tmp_path)
    assert done.returncode == 2 and "cannot draw" in done.stderr


def test_an_own_effect_goes_through_the_command_line(tmp_path):
    drive = ("simulate", "rcc", "--cycle", "udds[20:40]", "--imposed")
    on = ("--effect", OWN, "--with", "trailer:mass_kg=0.5")
    done = rccsim(*drive, *on, "-o", "run.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    done = rccsim("energy", "run.csv", "--json", cwd=tmp_path)
    report = json.loads(done.stdout)
    assert report["ledger"]["trailer"] > 0
    assert abs(report["residual"]) < 1e-6
    for wrong, message in (
        (("--effect", OWN), "not switched on"),
        (("--effect", "none.py", "--with", "trailer:mass_kg=1"), "cannot be read"),
        (("--effect", OWN, "--with", "trailer:weight=1"), "trailer has no weight"),
        (("--with", "trailer:mass_kg=1"), "no such effect"),
    ):
        done = rccsim(*drive, *wrong, cwd=tmp_path)
        assert done.returncode == 2 and message in done.stderr, done.stderr
        assert done.stdout == "" and "Traceback" not in done.stderr


@pytest.mark.parametrize("wind", [None, 2.0, -8.0])
def test_a_certified_load_and_its_exact_parts_drive_alike(wind):
    load = {"a_n": 0.8, "b_n_s_per_m": 0.3, "c_n_s2_per_m2": 0.03}
    certified = car({"road_load": load})
    rows = [row for row in converted(certified, 6.0) if row["how"] == "exact"]
    blown = {"headwind": {"speed_mps": wind}} if wind else {}
    parts = {**blown}
    for row in rows:
        _, effect, key = row["key"].split(".")
        parts.setdefault(effect, {})[key] = row["value"]
    in_wind = car({"road_load": load, **blown})
    one, two = simulate(in_wind, CYCLE), simulate(car(parts), CYCLE)
    for column in ("speed_mps", "motor_current_a"):
        scale = np.abs(one.trace[column]).max()
        assert np.abs(one.trace[column] - two.trace[column]).max() < 1e-3 * scale
    # damping takes its torque from the shaft, not from the road
    back = {row["key"].split(".")[2]: row["value"] for row in converted(car(parts), 6)}
    assert back == pytest.approx(load)


def test_rolling_and_drag_alone_are_the_least_squares_fit():
    A, B, C, m, V, rho = 199.3, 9.263, 0.3929, 3175.0, 30.0, 1.2
    ours = two_terms(A, B, C, m=m, v_max=V, rho=rho)
    v = np.linspace(0, V, 20001)
    force = road_load_force(v, v, A, B, C)
    basis = np.stack([np.full_like(v, m * G), 0.5 * rho * v * v], axis=1)
    theirs, *_ = np.linalg.lstsq(basis, force, rcond=None)
    assert ours["coefficient"] == pytest.approx(theirs[0], rel=1e-3)
    assert ours["drag_area_m2"] == pytest.approx(theirs[1], rel=1e-3)
    worst = np.abs(basis @ theirs - force).max()
    assert ours["worst_n"] == pytest.approx(worst, rel=1e-2)


def test_a_load_that_no_rolling_and_drag_can_give_is_refused():
    with pytest.raises(InputError, match="drag_area_m2: would be negative"):
        two_terms(100.0, -10.0, 0.1, m=1000.0, v_max=30.0, rho=1.2)
    with pytest.raises(InputError, match="states no road load"):
        converted(car({}), 30.0)
    shown = converted(load_vehicle("r1t_epa"), 30.0)
    assert {row["how"].split()[0] for row in shown} == {"exact", "fitted"}


def test_loads_that_leave_no_vehicle_are_refused():
    with pytest.raises(InputError, match="between the axles"):
        simulate(car({"cg_shift": {"shift_m": 0.3}}), CYCLE)
    with pytest.raises(InputError, match="weighs"):
        simulate(car({"payload": {"mass_kg": -4.0}}), CYCLE)
