"""The wheel runs away from the checkout; an edited effect does not run from a cache."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def run(python, *words, cwd):
    """Run `rccsim` of an environment, with nothing of this one in its way."""
    command = [python, "-m", "rcc_sim", *words]
    env = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, env=env)


@pytest.fixture(scope="session")
def installed(tmp_path_factory):
    """Python of an environment that has the built wheel and, from here, its needs."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    ignored = shutil.ignore_patterns(".*", "__pycache__", "build", "dist", "demo")
    shutil.copytree(ROOT, source, ignore=ignored)
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation"]
    subprocess.run([*build, "-o", folder, source], check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    make = [sys.executable, "-m", "venv", "--without-pip", folder / "env"]
    subprocess.run(make, check=True)
    python = folder / "env" / "bin" / "python"
    site = subprocess.run(
        [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout.strip()
    shutil.unpack_archive(wheel, site, format="zip")
    # after the wheel in the search order, and its own .pth files are not read, so that
    # a development install of this package does not hide the wheel
    Path(site, "needs.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return python


def test_the_wheel_runs_from_anywhere(installed, tmp_path):
    where = [installed, "-c", "import rcc_sim; print(rcc_sim.__file__)"]
    found = subprocess.run(where, capture_output=True, text=True, cwd=tmp_path)
    assert Path(installed).parents[1] in Path(found.stdout.strip()).parents

    listed = run(installed, "vehicles", "--json", cwd=tmp_path)
    rows = json.loads(listed.stdout)
    shipped = {path.stem for path in (ROOT / "vehicles").glob("*.toml")}
    assert {row["name"] for row in rows} == shipped
    assert all(row["source"] and row["origin"] == "shipped" for row in rows)

    groups = run(installed, "pi", "rcc", "r1t", "--json", cwd=tmp_path)
    assert json.loads(groups.stdout)["vehicles"] == ["rcc", "r1t"], groups.stderr

    drive = ("simulate", "rcc", "--cycle", "udds[20:40]", "--imposed")
    trace = run(installed, *drive, cwd=tmp_path)
    assert trace.returncode == 0, trace.stderr
    assert len(trace.stdout.splitlines()) == 22


def test_the_wheel_has_its_script_and_every_definition(installed):
    site = Path(installed).parents[1]
    (entry,) = site.glob("lib/*/site-packages/rccsim-*.dist-info/entry_points.txt")
    assert "rccsim = rcc_sim.cli.app:main" in entry.read_text()
    (shipped,) = site.glob("lib/*/site-packages/rcc_sim/_shipped")
    for folder in ("vehicles", "cycles"):
        there = {p.name for p in (shipped / folder).iterdir()}
        assert there >= {p.name for p in (ROOT / folder).iterdir() if p.is_file()}


def test_the_wheel_has_what_a_page_is_made_of(installed):
    site = Path(installed).parents[1]
    (report,) = site.glob("lib/*/site-packages/rcc_sim/report")
    assert {"report.css", "report.js"} <= {p.name for p in report.iterdir()}


@pytest.mark.slow
def test_an_edited_effect_takes_effect_in_the_next_process(tmp_path):
    shutil.copytree(
        ROOT / "rcc_sim",
        tmp_path / "rcc_sim",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    for folder in ("vehicles", "cycles"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    code = (
        "from rcc_sim.definitions.cycle import parse_cycle\n"
        "from rcc_sim.definitions.vehicle import load_vehicle\n"
        "from rcc_sim.simulate.run import simulate\n"
        "with_it = {'rolling_resistance': {'coefficient': 0.02}}\n"
        "car = load_vehicle('rcc').changed(effects=with_it)\n"
        "cycle = parse_cycle('udds[20:40]')\n"
        "run = simulate(car, cycle, imposed=True, engine='compiled')\n"
        "print(run.trace['energy_rolling_resistance_j'][-1])\n"
    )

    def rolling_energy():
        done = subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env=os.environ
            | {"RCCSIM_CACHE": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)},
        )
        assert done.returncode == 0, done.stderr
        return float(done.stdout)

    before = rolling_energy()
    assert rolling_energy() == before  # from the cache
    file = tmp_path / "rcc_sim" / "physics" / "effects" / "rolling_resistance.py"
    text = file.read_text()
    assert "return coefficient * F_z" in text
    file.write_text(text.replace("return coefficient", "return 2.0 * coefficient"))
    assert rolling_energy() == pytest.approx(2 * before)
