"""The similitude commands: contract, help, pipes and errors."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys

import pytest
import typer
from typer.testing import CliRunner

from rcc_sim.cli import match, motor_map, pi, scale, scale_cycle
from rcc_sim.errors import InputError

app = typer.Typer()
for command in (pi, match, scale, scale_cycle, motor_map):
    command.register(app)

COMMANDS = ("pi", "match", "scale", "scale-cycle", "motor-map")
TO_CAR = ("--from", "r1t", "--to", "rcc")


def run(*args, stdin=None):
    result = CliRunner().invoke(app, list(args), input=stdin)
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == 0, result.stderr
    return result


def document(*args):
    return json.loads(run(*args, "--json").stdout)


@pytest.mark.parametrize("command", COMMANDS)
def test_the_help_shows_an_example(command):
    assert f"rccsim {command}" in run(command, "--help").stdout


def test_pi_prints_the_contracts_document():
    found = document("pi", "rcc", "r1t")
    assert found["vehicles"] == ["rcc", "r1t"]
    assert len(found["groups"]) == 13
    group = {g["name"]: g for g in found["groups"]}["pi_6"]
    assert group["formula"] == "I_z/(m l^2)"
    assert group["values"] == pytest.approx([0.0963, 0.1331], rel=5e-3)
    assert (group["low"][1], group["high"][1]) == pytest.approx(
        (0.1065, 0.1597), rel=5e-3
    )
    assert found["scales"]["energy_per_distance"] == pytest.approx(90 / 40700)


def test_pi_writes_a_trace_dimensionless():
    trace = "time_s,speed_mps,motor_current_a\n0,0,1\n1,2,3\n"
    result = run("pi", "rcc", "--trace", "-", stdin=trace)
    assert result.stdout.splitlines()[0] == "pi_8_time,pi_9_speed"
    assert "motor_current_a" in result.stderr


def test_a_trace_goes_with_one_vehicle():
    with pytest.raises(InputError, match="one vehicle"):
        run("pi", "rcc", "r1t", "--trace", "-", stdin="time_s\n0\n")


def test_scale_prints_the_contracts_document():
    found = document("scale", "energy_per_distance", "1.0", *TO_CAR)
    assert found["factor"] == pytest.approx(90 / 40700)
    assert found["value"] == pytest.approx(90 / 40700)


def test_a_negative_value_is_scaled():
    found = document("scale", "acceleration", "-2", *TO_CAR)
    assert found["value"] == pytest.approx(-2 * found["factor"])


def test_a_scaled_cycle_is_a_cycle_again():
    there = run("scale-cycle", "udds[0:60]", *TO_CAR)
    rows = list(csv.DictReader(io.StringIO(there.stdout)))
    assert list(rows[0]) == ["time_s", "speed_mps"]
    back = run("scale-cycle", "-", "--from", "rcc", "--to", "r1t", stdin=there.stdout)
    assert float(back.stdout.splitlines()[-1].split(",")[0]) == pytest.approx(60)


def test_scale_cycle_says_what_the_car_cannot_drive():
    result = run("scale-cycle", "udds", *TO_CAR)
    assert "cannot drive: braking" in result.stderr
    assert "dead zone" in result.stderr
    assert "braking" not in result.stdout


def test_match_says_what_is_out_of_reach():
    found = document("match", "rcc", "--to", "r1t")
    assert "B" in found["out_of_reach"]
    instead = {c["symbol"]: c["other_instead"] for c in found["changes"]}
    assert instead["B"] == pytest.approx(0.2499, rel=5e-3)


def test_motor_map_writes_a_grid_and_a_picture(tmp_path):
    picture = tmp_path / "map.png"
    args = ("motor-map", "rcc", "--against", "r1t", "--plot", str(picture))
    found = document(*args, "--points", "7")
    assert len(found["efficiency"]) == 7
    assert 0 < found["against"]["share_inside"] < 1
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "args",
    [
        ("pi", "rcc", "r1t"),
        ("scale", "speed", "1", *TO_CAR),
        ("match", "rcc", "--to", "r1t"),
    ],
)
def test_these_commands_start_without_numpy(args):
    code = (
        "import sys, typer\n"
        "from rcc_sim.cli import match, pi, scale\n"
        "app = typer.Typer()\n"
        "for command in (match, pi, scale): command.register(app)\n"
        f"app({list(args)!r}, standalone_mode=False)\n"
        "heavy = {'numpy', 'scipy', 'pandas', 'numba'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
