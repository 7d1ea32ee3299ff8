"""Figures in a wrong unit are told by what does not grow with a car's size."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from rcc_sim.cli.app import app
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.similitude.unlikely import RATIOS, unlikely
from tests.similitude.similar import car

VEHICLES = sorted(
    (Path(__file__).resolve().parents[2] / "vehicles").glob("*.toml"),
    key=lambda path: path.name,
)
STATED = {
    "battery": {"capacity_ah": 5.2, "configuration": "3S"},
    "body": {"track_width_m": 0.25, "cg_height_m": 0.07},
    "effects": {
        "battery_resistance": {"resistance_ohm": 0.005},
        "copper_loss": {"phase_resistance_ohm": 0.005},
        "aerodynamic_drag": {"drag_area_m2": 0.011},
        "auxiliary_load": {"power_w": 8.0},
    },
}
SLIPS = [
    ("battery.capacity_ah", 1000),  # mAh
    ("battery.open_circuit_voltage_v", 12),  # a pack's for a cell's
    ("effects.battery_resistance.resistance_ohm", 1000),  # mOhm
    ("effects.copper_loss.phase_resistance_ohm", 1000),
    ("effects.drivetrain_damping.damping_nms_per_rad", 1000),  # mN m s
    ("effects.rotor_inertia.inertia_kgm2", 1e4),  # kg cm²
    ("effects.aerodynamic_drag.drag_area_m2", 100),  # the big car's
    ("effects.auxiliary_load.power_w", 1000),  # mW
    ("motor.flux_linkage_wb", 1000),  # mWb
    ("motor.velocity_constant_rpm_per_v", 0.1047),  # rad/s a volt
    ("tyres.front_cornering_stiffness_n_per_rad", 1 / 57.3),  # N a degree
    ("tyres.rear_cornering_stiffness_n_per_rad", 1 / 57.3),
    ("controller.max_current_a", 1000),  # mA
    ("body.track_width_m", 10),
    ("body.cg_height_m", 10),
]


def blamed(vehicle):
    return {what.split(":")[0] for what, _ in unlikely(vehicle)}


@pytest.mark.parametrize("path", VEHICLES, ids=lambda path: path.stem)
def test_nothing_is_unlikely_about_a_shipped_vehicle(path):
    assert not unlikely(load_vehicle(path))


def test_nothing_is_unlikely_about_a_full_sheet_of_a_small_car():
    small = car(**STATED)
    # without this no ratio of it would have been judged
    judged = {ratio.key for ratio in RATIOS if ratio.of(small) is not None}
    judged |= {r.stated(small) for r in RATIOS if r.stated}
    assert {key for key, _ in SLIPS} <= judged
    assert not unlikely(small)


@pytest.mark.parametrize(("key", "factor"), SLIPS, ids=[key for key, _ in SLIPS])
def test_a_slip_of_a_unit_is_told_with_the_figure(key, factor):
    sound = car(**STATED)
    slipped = sound.changed(settings={key: sound.figures()[key].value * factor})
    assert key in blamed(slipped)


def test_validate_tells_it_and_the_file_stays_sound(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        '[vehicle]\nname = "mine"\nextends = "rcc"\n[battery]\ncapacity_ah = 5200\n'
    )
    ran = CliRunner().invoke(app, ["vehicles", "validate", str(path)])
    assert ran.exit_code == 0
    assert "battery.capacity_ah: unlikely" in ran.output
    assert "5200 mAh is 5.2" in ran.output


def test_a_run_tells_it_too(tmp_path):
    out = tmp_path / "run.csv"
    words = ["simulate", "rcc", "--cycle", "udds[20:30]", "-o", str(out)]
    said = CliRunner().invoke(app, [*words, "--set", "battery.capacity_ah=5200"])
    assert said.exit_code == 0
    assert "battery.capacity_ah: unlikely" in said.stderr
    assert "unlikely" not in CliRunner().invoke(app, words).stderr
