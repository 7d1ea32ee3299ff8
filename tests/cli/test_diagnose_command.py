import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from rcc_sim.cli.diagnose import _of_mended
from rcc_sim.cli.logs import tell_notes
from tests.program import rccsim


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    log = tmp_path_factory.mktemp("drive") / "drive.csv"
    done = rccsim(
        "simulate", "rcc", "--cycle", "udds[20:60]", "--lane-change-every", "20",
        "--with", "auxiliary_load:power_w=3", "-o", log,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return log


@pytest.mark.slow
def test_a_diagnosis_writes_all_that_is_asked_for(drive, tmp_path):
    files = {
        "--write-vehicle": tmp_path / "mended.toml",
        "--profiles": tmp_path / "profiles.csv",
        "--next-run": tmp_path / "next.csv",
        "--html": tmp_path / "page.html",
        "--plot": tmp_path / "plot.png",
    }
    options = [word for pair in files.items() for word in pair]
    done = rccsim("diagnose", drive, "--vehicle", "rcc", "--json", *options)
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert "auxiliary_load" in [c["effect"] for c in document["causes"]]
    assert all(path.stat().st_size > 20 for path in files.values())
    assert "no cause varies" in done.stderr  # so that the profiles hold time alone
    assert files["--profiles"].read_text().splitlines()[0] == "time_s"
    value = document["causes"][0]["parameters"]["power_w"]["value"]
    assert value == pytest.approx(3, rel=0.05)
    gap = rccsim("gap", drive, "--vehicle", files["--write-vehicle"], "--json")
    assert abs(json.loads(gap.stdout)["energy"]["gap_percent"]) < 3


def test_a_bag_of_what_is_not_commanded_is_refused_before_the_work(drive, tmp_path):
    """After it all was lost but the mended file."""
    log, mended = tmp_path / "imposed.csv", tmp_path / "mended.toml"
    table = pd.read_csv(drive)[["time_s", "speed_mps", "battery_power_w"]]
    table.to_csv(log, index=False)
    asked = ("--next-run", tmp_path / "n.mcap", "--write-vehicle", mended)
    done = rccsim("diagnose", log, "--vehicle", "rcc", *asked)
    assert done.returncode == 2 and "should end in .csv where speed_mps" in done.stderr
    assert not mended.exists() and "refining" not in done.stderr


@pytest.mark.parametrize("closed", ["1", "2"])
def test_a_stream_that_was_closed_is_no_error(closed):
    code = f"import os; os.close({closed}); "
    code += "os.execvp(sys.executable, [sys.executable, '-m', 'rcc_sim', 'vehicles'])"
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; {code}"], capture_output=True, text=True
    )
    assert done.returncode == 0 and "Traceback" not in done.stderr


@pytest.mark.slow
def test_a_mended_file_without_a_cause_is_said_to_be_one(drive, tmp_path):
    names, path = "payload,yaw_rate_bias", tmp_path / "mended.toml"
    asked = ("--candidates", names, "--write-vehicle", path, "--json")
    done = rccsim("diagnose", drive, "--vehicle", "rcc", *asked)
    document = json.loads(done.stdout)
    assert not document["causes"]
    assert {r["effect"] for r in document["ranking"]} >= set(names.split(","))
    assert "note: no cause; " in done.stderr
    other = tmp_path / "other.csv"
    other.write_bytes(drive.read_bytes())
    held = ("--candidates", names, "--holdout", other, "--text")
    done = rccsim("diagnose", drive, "--vehicle", "rcc", *held)
    assert "\nPROOF    there is no cause to hold against" in done.stdout


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--vehicle", "rcx"], "rcx"),
        (["--vehicle", "rcc", "--hide", "no_such_column"], "no_such_column"),
        (["--vehicle", "rcc", "--candidates", "no_such"], "no such effect"),
        (["--vehicle", "rcc", "--candidates", "heater"], "mean `auxiliary_load`?"),
        (["--vehicle", "rcc", "--withhold", "tyre_saturation"], "does not have it"),
        (["--vehicle", "rcc", "--plot", "p.jpeg"], "cannot draw into a .jpeg"),
    ],
)
def test_wrong_words_are_told(drive, words, told):
    done = rccsim("diagnose", drive, *words)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("error: ") and told in done.stderr


def test_a_log_is_out_or_back_and_belongs_to_no_fleet(drive):
    twice = rccsim("diagnose", drive, "--back", drive, "--vehicle", "rcc")
    fleet = rccsim("diagnose", drive, "--each", "--back", drive, "--vehicle", "rcc")
    for done, told in ((twice, "drive.csv"), (fleet, "--back")):
        assert done.returncode == 2 and done.stdout == ""
        assert done.stderr.startswith("error: ") and told in done.stderr


def test_an_empty_log_is_told(tmp_path):
    (tmp_path / "empty.csv").touch()
    done = rccsim("diagnose", tmp_path / "empty.csv", "--vehicle", "rcc")
    assert done.returncode == 2
    assert "empty" in done.stderr


@pytest.mark.slow
def test_the_screen_is_printed_where_piped_if_asked_for(tmp_path):
    drive = tmp_path / "drive.csv"
    drove = ("simulate", "rcc", "--cycle", "udds[20:50]", "-o", drive)
    rccsim(*drove, "--with", "auxiliary_load:power_w=3")
    asked = ("diagnose", drive, "--vehicle", "rcc", "--text")
    asked += ("--candidates", "auxiliary_load,payload")
    piped = rccsim(*asked)
    assert piped.returncode == 0, piped.stderr
    assert [line.split()[0] for line in piped.stdout.splitlines()[:1]] == ["GAP"]
    assert "\nVERDICT " in piped.stdout and "\nCAUSE    auxiliary_load" in piped.stdout
    kept = tmp_path / "screen.txt"
    rccsim(*asked, "-o", kept)
    assert kept.read_text() == piped.stdout


def test_what_several_logs_have_in_common_is_said_once(capsys):
    tell_notes([("a.csv", ["no battery", "late"]), ("b.csv", ["no battery"])])
    assert capsys.readouterr().err.splitlines() == [
        "note: all 2 logs: no battery",
        "note: a.csv: late",
    ]
    tell_notes([("a.csv", ["late"]), ("b.csv", ["late"]), ("c.csv", [])])
    assert capsys.readouterr().err == "note: 2 of 3 logs: late\n"
    tell_notes([("a.csv", ["late"])])
    assert capsys.readouterr().err == "note: late\n"


def unmended(status="no_gap", after=None):
    """A diagnosis without a cause."""
    return SimpleNamespace(
        asserted=[], elsewhere={}, hidden=(), gaps=(1,), figures=dict, effects=dict,
        proof=SimpleNamespace(before=51.7, after=after), status=status,
    )  # fmt: skip


@pytest.mark.parametrize("status", ["no_gap", "unexplained"])
def test_figures_beside_a_gap_that_nothing_explains_may_stand_in_for_it(status):
    """A controller that cuts its current was an integral gain 8.3 sds off."""
    (note,) = _of_mended(unmended(status), Path("m.toml"))
    assert ("stand in" in note) == (status == "unexplained")


@pytest.mark.parametrize(
    ("after", "told"), [(77.8, True), (52.9, False), (None, False)]
)
def test_a_mended_file_with_which_the_energy_gap_grows_says_so(after, told):
    """A mass of a third may suit each row, and not the energy."""
    found = unmended(after=after)
    notes = [n for n in _of_mended(found, Path("m.toml")) if "grows" in n]
    assert bool(notes) is told
    assert not told or "from +51.7 to +77.8 %" in notes[0]
