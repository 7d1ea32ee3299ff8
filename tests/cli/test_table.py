"""What a person sees on a terminal: whole numbers at any width."""

import re

import pytest

from tests import terminal
from tests.program import rccsim


def on_terminal(width, *args):
    """Run a command on a terminal of its own; return what it shows."""
    code, shown = terminal.on_terminal(*args, width=width, NO_COLOR="1")
    assert code == 0
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown).replace("\r", "")


COMMANDS = [
    (("pi", "rcc", "r1t"), "3.44e-06"),
    (("match", "rcc", "--to", "r1t"), "0.0382"),
    (
        ("scale", "energy_per_distance", "1.0", "--from", "r1t", "--to", "rcc"),
        "0.002211",
    ),
    (("cycles",), "udds"),
    (("vehicles",), "r1t_epa"),
    (("vehicles", "show", "rcc"), "3.78"),
    (("effects", "show", "rolling_resistance"), "coefficient"),
]


@pytest.mark.parametrize("width", [60, 80, 140])
@pytest.mark.parametrize(("words", "number"), COMMANDS, ids=lambda x: str(x)[:20])
def test_a_table_cuts_no_number_and_stays_within_the_width(width, words, number):
    shown = on_terminal(width, *words)
    assert number in shown
    assert "…" not in shown.replace("energy_…", "")
    assert max(len(line) for line in shown.splitlines()) <= width


def test_a_single_row_is_shown_downwards():
    shown = on_terminal(60, "step", "--speed", "527", "--torque", "0.0067",
                        "--time-constant", "0.196")  # fmt: skip
    assert re.search(r"damping_nms_per_rad +1\.271e-05", shown)


def test_a_long_table_is_shown_in_part_and_says_so():
    shown = on_terminal(80, "cycles", "show", "udds")
    assert "more rows" in shown
    assert len(shown.splitlines()) < 40


def test_what_a_terminal_shows_goes_where_it_is_asked_for(tmp_path):
    words, file = ("vehicles", "validate", "rcc", "r1t"), tmp_path / "told.txt"
    shown = on_terminal(80, *words)
    assert rccsim(*words, "--text").stdout.splitlines() == shown.splitlines()
    assert rccsim(*words, "--text", "-o", str(file)).returncode == 0
    assert file.read_text(encoding="utf-8").splitlines() == shown.splitlines()
    both = rccsim(*words, "--text", "--csv")
    assert both.returncode == 2 and "--text and --csv: one of them" in both.stderr
