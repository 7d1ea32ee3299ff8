"""The house: the start, and what every command, vehicle and effect keeps to."""

from __future__ import annotations

import json
import re
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.main import get_command

from rcc_sim.cli.app import app, command_names
from rcc_sim.definitions.vehicle import TABLES, load_vehicle
from tests.program import rccsim

ROOT = Path(__file__).resolve().parents[1]
HEAVY = {"numpy", "pandas", "scipy", "numba", "matplotlib", "pyarrow"}


def run(*arguments, env=None, **options):
    """Run `rccsim` in a window of 80 columns, or as wide as ``env`` says."""
    return rccsim(*arguments, env={"COLUMNS": "80"} | (env or {}), **options)


def paths(command, ctx, words=()):
    """Yield the words that name each command and each one under it."""
    for name in command.list_commands(ctx):
        under = command.get_command(ctx, name)
        yield (*words, name)
        if hasattr(under, "list_commands"):
            yield from paths(under, ctx, (*words, name))


ROOT_COMMAND = get_command(app)
COMMANDS = list(paths(ROOT_COMMAND, typer.Context(ROOT_COMMAND)))


# The start


@pytest.mark.parametrize(
    "words",
    [
        "--help",
        "pi rcc r1t",
        "match rcc --to r1t",
        "scale speed 25 --from r1t --to rcc",
        "vehicles",
        "vehicles show rcc",
        "effects",
    ],
)
def test_a_quick_command_loads_nothing_heavy(words, tmp_path):
    code = (
        "import sys\nfrom rcc_sim.cli.app import main\n"
        f"sys.argv = ['rccsim', *{words.split()!r}]\n"
        "try:\n    main()\nfinally:\n"
        "    print(*{m.partition('.')[0] for m in sys.modules}, file=sys.stderr)\n"
    )
    python = [sys.executable, "-c", code]
    done = subprocess.run(python, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert not HEAVY & set(done.stderr.split())


@pytest.mark.parametrize("words", [["--help"], ["pi", "rcc", "r1t"], ["vehicles"]])
def test_a_quick_command_is_quick(words, tmp_path):
    def seconds(*command):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(
            [sys.executable, *command], capture_output=True, cwd=tmp_path
        )
        assert done.returncode == 0, done.stderr
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    # 0.2 s where the libraries alone take 0.09, as a ratio of the processor's time:
    # machines differ, and tests run side by side
    libraries = "-c", "import typer; from pydantic import BaseModel, Field, TypeAdapter"
    pairs = [(seconds("-m", "rcc_sim", *words), seconds(*libraries)) for _ in range(5)]
    assert min(a for a, _ in pairs) < 2.2 * min(b for _, b in pairs)


# The commands


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_command_has_help_with_an_example(words):
    done = run(*words, "--help")
    assert (done.returncode, done.stderr) == (0, "")
    text = " ".join(done.stdout.split())
    assert re.search(rf"Example: .*rccsim {' '.join(words)}\b", text)


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_an_example_of_the_help_uses_real_options(words):
    command = ROOT_COMMAND
    for word in words:
        command = command.get_command(None, word)
    known = {option for param in command.params for option in param.opts}
    text = " ".join(f"{command.help} {command.epilog}".split())
    examples = re.findall(rf"rccsim {' '.join(words)}( [^|;]*)", text)
    used = {o for e in examples for o in re.findall(r" (--?[a-z][a-z-]*)", e)}
    assert used <= known


def test_help_lists_every_command_in_a_line_or_two():
    text = run("--help").stdout
    for name in command_names():
        assert re.search(rf"^  {name}  +\S", text, re.MULTILINE)
    assert run().stdout == text


def test_help_is_whole_without_colour_and_on_a_narrow_terminal():
    for width in ("40", "80", "200"):
        text = run("simulate", "--help", env={"COLUMNS": width}).stdout
        assert "\x1b" not in text and "…" not in text
        assert "--lane-change-every" in text


@pytest.mark.parametrize(
    "words",
    [
        ["simulte"],
        ["--nonsense"],
        ["vehicles", "nonsense"],
        ["vehicles", "show"],
        ["vehicles", "show", "nonsense"],
        ["vehicles", "show", "."],
        ["vehicles", "new", "../../up"],
        ["pi", "nonsense"],
        ["pi"],
        ["cycles", "show", "nonsense"],
        ["cycles", "show", "udds[20:]["],
        ["effects", "show", "gearloss"],
        ["simulate", "rcc", "--cycle", "nonsense"],
        ["scale", "speed", "fast", "--from", "r1t", "--to", "rcc"],
    ],
    ids=" ".join,
)
def test_a_users_mistake_is_one_error_line_and_exit_2(words, tmp_path):
    done = run(*words, cwd=tmp_path)
    lines = done.stderr.splitlines()
    assert done.returncode == 2
    assert done.stdout == ""
    assert lines[0].startswith("error: ")
    assert all(line.startswith("hint: ") for line in lines[1:])
    assert len(lines) <= 2


@pytest.mark.parametrize("name", sorted({*command_names()} - {"demo"}))
def test_a_command_called_with_nothing_works_or_says_what_is_missing(name, tmp_path):
    done = run(name, cwd=tmp_path)
    assert done.returncode in (0, 2)
    assert "Traceback" not in done.stderr
    assert done.returncode == 0 or done.stderr.startswith("error: ")


def test_a_close_name_is_offered():
    assert "`simulate`" in run("simulte").stderr
    assert "`gear_loss`" in run("effects", "show", "gearloss").stderr


def test_a_broken_pipe_is_quiet():
    command = [sys.executable, "-m", "rcc_sim", "cycles", "show", "udds*200"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, cwd=ROOT) as process:
        process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(timeout=60) == 141


def test_ctrl_c_says_so_and_gives_130(tmp_path):
    command = [sys.executable, "-m", "rcc_sim", "cycles", "show", "-"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe) as process:
        process.stdin.write(b"time_s,speed_mps\n")
        process.stdin.write(b"".join(b"%d,1\n" % t for t in range(50_000)))
        process.stdin.flush()  # more than a pipe holds, so that the command is reading
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=30) == 130
        assert process.stderr.read() == b"interrupted\n"


def test_the_shell_completes_commands_vehicles_cycles_and_effects(tmp_path):
    def completed(words):
        cursor = str(len(words.split()) - 1)
        env = {"_RCCSIM_COMPLETE": "complete_bash", "COMP_WORDS": words}
        return run(cwd=tmp_path, env=env | {"COMP_CWORD": cursor}).stdout.split()

    assert completed("rccsim simu") == ["simulate"]
    assert completed("rccsim vehicles show r1") == ["r1t", "r1t_epa"]
    assert completed("rccsim cycles show ud") == ["udds"]
    assert completed("rccsim effects show gear") == ["gear_loss"]
    disabled = {"_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    shown = run("--show-completion", "bash", env=disabled)
    assert "_RCCSIM_COMPLETE" in shown.stdout


# The definitions


@pytest.mark.parametrize("path", sorted((ROOT / "vehicles").glob("*.toml")), ids=str)
def test_a_shipped_vehicle_validates_and_bears_its_files_name(path):
    done = run("vehicles", "validate", path)
    assert done.returncode == 0, done.stdout
    assert load_vehicle(path).name == path.stem


def test_validate_lists_everything_that_is_wrong(tmp_path):
    text = (ROOT / "vehicles" / "rcc.toml").read_text()
    text = text.replace("[tyres]", "[tyres]\nspikes = 4").replace("gear_ratio", "gear")
    text += (
        "\n[effects.gear_loss]\nefficiency = 7\n[effects.anti_gravity]\nforce_n = 1\n"
    )
    (tmp_path / "car.toml").write_text(text.replace("0.0382", '"heavy"'))
    done = run("vehicles", "validate", "car.toml", "rcc", "--json", cwd=tmp_path)
    assert done.returncode == 1
    rows = json.loads(done.stdout)
    problems = " ".join(row["problem"] for row in rows)
    for key in (
        "tyres.spikes",
        "drivetrain.gear:",
        "drivetrain.gear_ratio: missing",
        "body.yaw_inertia_kgm2",
        "effects.gear_loss.efficiency",
        "effects.anti_gravity",
    ):
        assert key in problems
    assert rows[-1] == {"file": "rcc", "sound": True, "problem": "", "hint": ""}


def test_a_broken_file_is_a_row_of_the_list_and_not_its_end(tmp_path):
    (tmp_path / "vehicles").mkdir()
    (tmp_path / "vehicles" / "broken.toml").write_text("[vehicle\n")
    (tmp_path / "vehicles" / "image.toml").write_bytes(b"\xff\xd8\xff")
    rows = json.loads(run("vehicles", "--json", cwd=tmp_path).stdout)
    problems = {row["name"]: row["problem"] for row in rows}
    assert "not TOML" in problems["broken"] and "UTF-8" in problems["image"]
    assert problems["rcc"] == ""


def test_a_new_vehicle_extends_its_model_and_is_not_overwritten(tmp_path):
    assert run("vehicles", "new", "mine", "--like", "r1t", cwd=tmp_path).returncode == 0
    mine, r1t = load_vehicle(tmp_path / "vehicles" / "mine.toml"), load_vehicle("r1t")
    assert mine.figures() == r1t.figures()
    assert run("vehicles", "new", "mine", cwd=tmp_path).returncode == 2
    hidden = run("vehicles", "new", "rcc", cwd=tmp_path)
    assert hidden.returncode == 2 and "would hide it" in hidden.stderr
    assert run("vehicles", "new", "mine", "--force", cwd=tmp_path).returncode == 0


def test_a_blank_sheet_lacks_exactly_what_is_needed(tmp_path):
    run("vehicles", "new", "mine", "-o", "mine.toml", cwd=tmp_path)
    done = run("vehicles", "validate", "mine.toml", "--json", cwd=tmp_path)
    missing = {
        row["problem"].split(": ")[1]
        for row in json.loads(done.stdout)
        if row["problem"].endswith(": missing")
    }
    assert missing == {
        f"{table}.{key}"
        for table in ("body", "tyres", "drivetrain")
        for key, field in TABLES[table].model_fields.items()
        if field.is_required()
    }


def test_vehicles_show_gives_every_figure_of_a_vehicle_and_of_its_base():
    shown = json.loads(run("vehicles", "show", "r1t_epa", "--json").stdout)
    figures = {row["key"]: row for row in shown["figures"]}
    vehicle = load_vehicle("r1t_epa")
    assert figures.keys() >= vehicle.figures().keys()
    inertia = figures["body.yaw_inertia_kgm2"]  # stated by the base, as a range
    assert (inertia["low"], inertia["high"], inertia["unit"]) == (4000, 6000, "kg m²")
    assert shown["effects"] == list(vehicle.effects)
