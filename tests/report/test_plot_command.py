"""`rccsim plot`: every figure in every format, names as text, errors in one line."""

from __future__ import annotations

import json
from xml.etree import ElementTree

import matplotlib.colors
import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.report.figures import plot_cycles, plot_gap, plot_overlay
from rcc_sim.report.plots import COLOURS, plot_run, save
from rcc_sim.similitude.dimensionless import dimensionless_trace
from rcc_sim.trace import read_trace
from tests.program import rccsim
from tests.report.made import NASTY, diagnosis_report

GAP = {
    "where": {
        "energy": {"gap_wh": 0.06, "gap_percent": 24.0},
        "regimes": [
            {"regime": NASTY, "time_s": 31.0, "gap_wh": 0.05, "share": 0.83},
            {"regime": "braking", "time_s": 3.0, "gap_wh": -0.005, "share": -0.08},
        ],
        "stages": [{"stage": "electrical", "gap_wh": 0.01, "share": 0.17}],
    }
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a drive at two sizes and a gap."""
    place = tmp_path_factory.mktemp("plots")
    (place / "gap.json").write_text(json.dumps(GAP))
    part = "udds[20:60]"
    for words in (
        ("scale-cycle", part, "--from", "r1t", "--to", "rcc", "-o", "s.csv"),
        ("simulate", "rcc", "--cycle", "s.csv", "--imposed", "-o", "small.csv"),
        ("simulate", "r1t", "--cycle", part, "--imposed", "-o", "large.csv"),
    ):
        assert rccsim(*words, cwd=place).returncode == 0
    return place


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        "cycle udds --from r1t --to rcc",
        "run small.csv large.csv",
        "gap gap.json",
        pytest.param("pi rcc=small.csv r1t=large.csv", marks=pytest.mark.thorough),
        pytest.param(
            "motor-map rcc --against r1t --cycle udds[20:60]",
            marks=pytest.mark.thorough,
        ),
        pytest.param("effect rolling_resistance", marks=pytest.mark.thorough),
    ],
)
def test_a_figure_is_written_whole_and_twice_the_same(words, folder, tmp_path):
    heads = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}
    for ending, head in heads.items():
        pictures = []
        for name in ("one", "two") if ending == ".svg" else ("one",):
            path = tmp_path / f"{name}{ending}"
            done = rccsim("plot", *words.split(), "-o", path, cwd=folder)
            assert (done.returncode, done.stdout) == (0, ""), done.stderr
            pictures.append(path.read_bytes())
        assert pictures[0].startswith(head) and pictures[0] == pictures[-1]


@pytest.mark.parametrize("ending", [".png", ".svg", ".pdf"])
def test_a_figure_is_the_same_on_another_day(ending, tmp_path, monkeypatch):
    pictures = []
    for day in ("0", "86400"):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", day)
        save(plot_gap(GAP), tmp_path / f"a{ending}")
        pictures.append((tmp_path / f"a{ending}").read_bytes())
    assert pictures[0] == pictures[1]


@pytest.mark.parametrize(
    "words",
    [
        "cycle nonsense --from r1t --to rcc -o a.png",
        "cycle udds --from r1t --to rcc -o a.txt",
        "cycle udds --from r1t --to rcc -o nowhere/a.png",
        "run nothing.csv -o a.png",
        "pi small.csv -o a.png",
        "pi rcc=gap.json -o a.png",
        "gap small.csv -o a.png",
        "gap nothing.json -o a.png",
        "effect nonsense -o a.png",
        "motor-map rcc -o a.gif",
    ],
)
def test_a_mistake_is_one_line_and_leaves_no_file(words, folder):
    done = rccsim("plot", *words.split(), cwd=folder)
    lines = done.stderr.splitlines()
    assert done.returncode == 2 and done.stdout == ""
    assert lines[0].startswith("error: ") and "Traceback" not in done.stderr
    assert not list(folder.glob("a.*"))


@pytest.mark.parametrize(
    "found",
    [
        {},
        {"where": None},
        {"where": {"regimes": []}},
        {"where": {"regimes": [{"gap_wh": 1.0}]}},
        {"where": {"regimes": [{"regime": "x", "gap_wh": "much"}]}},
    ],
    ids=str,
)
def test_what_is_no_gap_is_refused(found):
    from rcc_sim.errors import InputError

    with pytest.raises(InputError):
        plot_gap(found)


def test_a_name_with_markup_is_text_in_svg(tmp_path):
    log = diagnosis_report(18.0, NASTY).measured
    for k, figure in enumerate((plot_gap(GAP), plot_run(log, log))):
        save(figure, tmp_path / f"{k}.svg")
        tree = ElementTree.parse(tmp_path / f"{k}.svg")
        names = {element.tag.rpartition("}")[2] for element in tree.iter()}
        assert "script" not in names


def test_a_scaled_cycle_keeps_its_points_in_both_curves():
    cycle = Cycle("c", np.array([0.0, 5, 9]), np.array([0.0, 8, 0]))
    half = Cycle("h", np.array([0.0, 2.5, 4.5]), np.array([0.0, 4, 0]))
    both, alone = plot_cycles(cycle, half, ("actual", "scaled")).axes
    for axis, drawn in ((both, (cycle, half)), (alone, (half,))):
        for line, told in zip(axis.lines, drawn, strict=True):
            assert np.array_equal(line.get_xdata(), told.time_s)
            assert np.array_equal(line.get_ydata(), told.speed_mps)
        assert axis.get_ylabel() == "Speed [m/s]"
    assert alone.get_xlabel() == "Time [s]"


def test_an_imposed_drive_of_two_sizes_is_one_line_in_pi_space(folder):
    runs = {
        name: dimensionless_trace(read_trace(folder / file), load_vehicle(name))
        for name, file in (("rcc", "small.csv"), ("r1t", "large.csv"))
    }
    speed = plot_overlay(runs).axes[0]
    small, large = (line.get_ydata() for line in speed.lines)
    assert small == pytest.approx(large, rel=1e-6, abs=1e-9)


def test_every_axis_of_a_gap_names_unit_and_bars_have_their_size():
    regimes, stages = plot_gap(GAP).axes
    assert [bar.get_width() for bar in regimes.patches] == [0.05, -0.005]
    assert stages.get_xlabel().endswith("[Wh]")


def test_colours_differ_in_lightness_too():
    def lightness(colour):
        return np.dot(matplotlib.colors.to_rgb(colour), (0.2126, 0.7152, 0.0722))

    first = [lightness(colour) for colour in COLOURS[:2]]
    assert abs(first[0] - first[1]) > 0.05
