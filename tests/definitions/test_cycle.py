"""Drive cycles: the shipped tables, reading, cutting and joining."""

import contextlib
import gzip
import io
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcc_sim.definitions.cycle import (
    Cycle,
    join,
    list_cycles,
    parse_cycle,
    read_cycle,
)
from rcc_sim.definitions.library import Place
from rcc_sim.errors import InputError

SHIPPED = Path(__file__).parents[2] / "cycles"
REFERENCE = Path(__file__).parents[2].parent / "shared" / "data" / "cycles"
REFERENCE_NAMES = {"ftp75": "ftp75_no_soak"}
PLACES = [Place(SHIPPED, "shipped")]
ABOUT = tomllib.loads((SHIPPED / "cycles.toml").read_text(encoding="utf-8"))
NAMES = sorted(path.stem for path in SHIPPED.glob("*.csv"))


@st.composite
def cycles(draw):
    n = draw(st.integers(2, 30))
    steps = draw(st.lists(st.floats(0.01, 10.0), min_size=n - 1, max_size=n - 1))
    speed = draw(st.lists(st.floats(0.0, 40.0), min_size=n, max_size=n))
    start = draw(st.floats(-100.0, 1e4))
    return Cycle("drawn", start + np.concatenate(([0.0], np.cumsum(steps))), speed)


def named(spec):
    return parse_cycle(spec, places=PLACES)


# The shipped tables


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_cycle_is_as_long_as_published(name):
    table = ABOUT[name]
    published = table.get("table_distance_m", table["distance_m"])
    assert named(name).distance == pytest.approx(published, rel=0.002)


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_cycle_equals_the_independent_reference(name):
    other = REFERENCE_NAMES.get(name, name.replace("artemis_", "cadc_"))
    path = REFERENCE / f"{other}.csv"
    if not path.is_file():
        pytest.skip(f"the reference table {path.name} is not on this machine")
    ours, theirs = named(name), read_cycle(path)
    np.testing.assert_array_equal(ours.time_s, theirs.time_s)
    np.testing.assert_allclose(ours.speed_mps, theirs.speed_mps, atol=1e-4, rtol=0)


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_cycle_starts_and_ends_standing_still_at_one_hertz(name):
    cycle = named(name)
    assert cycle.speed_mps[0] == cycle.speed_mps[-1] == 0.0
    np.testing.assert_array_equal(cycle.time_s, np.arange(cycle.time_s.size))


def test_every_shipped_cycle_states_its_title_source_licence_and_distance():
    assert sorted(ABOUT) == NAMES
    for table in ABOUT.values():
        assert {"title", "source", "licence", "distance_m"} <= set(table)


def test_ftp75_is_udds_and_then_its_first_505_seconds():
    composed, shipped = named("udds+udds[0:505]"), named("ftp75")
    np.testing.assert_allclose(composed.time_s, shipped.time_s)
    np.testing.assert_allclose(composed.speed_mps, shipped.speed_mps)


def test_the_two_stretches_of_the_paper_have_their_lengths():
    assert named("udds[510:680]").distance == pytest.approx(1014, abs=1)
    assert named("udds[20:125]").distance == pytest.approx(1083, abs=1)


# Laws of cutting and joining


@given(cycles(), st.floats(0.05, 0.95))
def test_a_cycle_cut_in_two_and_joined_again_keeps_distance_and_duration(cycle, part):
    cut = part * cycle.duration
    again = join(cycle.slice(stop=cut), cycle.slice(start=cut))
    assert again.distance == pytest.approx(cycle.distance, rel=1e-9, abs=1e-6)
    assert again.duration == pytest.approx(cycle.duration)


@given(cycles(), st.integers(1, 6))
def test_a_closed_cycle_repeated_n_times_is_n_times_as_long(cycle, n):
    speed = cycle.speed_mps.copy()
    speed[-1] = speed[0]
    closed = Cycle("closed", cycle.time_s, speed)
    repeated = closed.repeat(n)
    assert repeated.distance == pytest.approx(n * closed.distance)
    assert repeated.duration == pytest.approx(n * closed.duration)
    assert repeated.time_s.size == n * (closed.time_s.size - 1) + 1


@given(cycles())
def test_a_whole_slice_is_the_cycle_with_its_time_from_0(cycle):
    whole = cycle.slice()
    np.testing.assert_allclose(whole.time_s, cycle.time_s - cycle.time_s[0])
    np.testing.assert_array_equal(whole.speed_mps, cycle.speed_mps)


@given(cycles(), st.floats(-1e3, 1e3))
def test_the_clock_at_the_start_changes_no_length(cycle, shift):
    later = Cycle("later", cycle.time_s + shift, cycle.speed_mps)
    assert later.distance == pytest.approx(cycle.distance, rel=1e-6, abs=1e-6)


def test_the_ends_of_a_slice_are_interpolated():
    ramp = Cycle("ramp", [100.0, 110.0], [0.0, 10.0])
    part = ramp.slice(2.5, 7.5)
    np.testing.assert_allclose(part.time_s, [0.0, 5.0])
    np.testing.assert_allclose(part.speed_mps, [2.5, 7.5])


def test_acceleration_and_deceleration_are_the_steepest_steps():
    cycle = Cycle("c", [0, 2, 3, 7], [0, 4, 1, 2])
    assert (cycle.max_acceleration, cycle.max_deceleration) == (2.0, 3.0)
    assert cycle.max_speed == 4.0


def test_a_jump_at_a_seam_is_refused():
    with pytest.raises(InputError, match=r"jump at the seam: 10 to 0 m/s"):
        join(Cycle("a", [0, 1, 2], [10, 10, 10]), Cycle("b", [0, 1, 2], [0, 1, 2]))


def test_a_difference_that_one_step_covers_is_driven_in_one_step():
    a, b = Cycle("a", [0, 1, 2], [0, 2, 4]), Cycle("b", [5, 6, 7], [5, 6, 7])
    both = join(a, b)
    np.testing.assert_allclose(both.time_s, [0, 1, 2, 3, 4, 5])
    np.testing.assert_allclose(both.speed_mps, [0, 2, 4, 5, 6, 7])


@pytest.mark.parametrize(("start", "stop"), [(-1, 5), (5, 5), (6, 5), (0, 11)])
def test_a_slice_outside_the_cycle_is_refused(start, stop):
    with pytest.raises(InputError, match="should lie inside") as error:
        Cycle("ten", [0, 10], [1, 1]).slice(start, stop)
    assert "lasts 10 s" in error.value.hint


def test_a_cycle_repeated_beyond_memory_is_refused_at_once():
    with pytest.raises(InputError, match="at most 20,000,000 rows"):
        named("udds*100000")


# What a cycle must be


@pytest.mark.parametrize(
    ("time", "speed", "message"),
    [
        ([0], [0], "at least 2 rows: 1"),
        ([0, 1], [0], "as many speeds as times: 2 and 1"),
        ([0, 1, 1], [0, 1, 2], "row 3: time_s should be greater"),
        ([0, 2, 1], [0, 1, 2], "row 3: time_s should be greater"),
        ([0, np.nan], [0, 1], "row 2: time_s should be finite: nan"),
        ([0, np.inf], [0, 1], "row 2: time_s should be finite: inf"),
        ([0, 1], [0, np.nan], "row 2: speed should be finite: nan"),
        ([0, 1], [0, -1], "row 2: speed should be at least 0: -1"),
        ([[0, 1]], [[0, 1]], "one column: 2 dimensions"),
        (["a", "b"], [0, 1], "should hold numbers"),
    ],
)
def test_an_unsound_cycle_is_refused(time, speed, message):
    with pytest.raises(InputError, match=message):
        Cycle("bad", time, speed)


def test_a_cycle_cannot_be_changed_through_its_arrays():
    time = np.array([0.0, 1.0])
    cycle = Cycle("c", time, time)
    time[0] = 0.5
    assert cycle.time_s[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        cycle.speed_mps[0] = 3.0


# Reading


@pytest.mark.parametrize(
    "text",
    [
        "time_s,speed_mps\n0,0\n1,2.5\n",
        "\ufefftime_s,speed_mps\r\n0,0\r\n1,2.5\r\n",
        'speed_mps , note,"time_s"\n0,x,0\n 2.5 ,,1\n',
        "time_s,speed_mps,\n0,0,\n1,2.5,\n\n  \n,,\n",
        "time_s,speed_ref_mps\n0,0\n1,2.5",
        "time_s,speed_ref_mps,speed_mps\n0,9,0\n1,9,2.5",
    ],
)
def test_a_sound_table_is_read_whatever_its_dress(text, tmp_path):
    (tmp_path / "c.csv").write_bytes(text.encode())
    with gzip.open(tmp_path / "c.csv.gz", "wt", encoding="utf-8", newline="") as file:
        file.write(text)
    for source in (tmp_path / "c.csv", tmp_path / "c.csv.gz", io.StringIO(text)):
        cycle = read_cycle(source, "c")
        np.testing.assert_array_equal(cycle.time_s, [0, 1])
        np.testing.assert_array_equal(cycle.speed_mps, [0, 2.5])


HEAD = "time_s,speed_mps\n"


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        ("", "should not be empty", "time_s"),
        ("\n \n", "should not be empty", "time_s"),
        (HEAD, "at least 2 rows: 0", ""),
        (HEAD + "0,0\n", "at least 2 rows: 1", ""),
        ("0,0\n1,1\n", "line 1: the header should have time_s and", "no header"),
        ("time_s,speed_kmh\n0,0\n", "speed_mps: time_s, speed_kmh", "divide by 3.6"),
        ("time_s,v mph\n0,0\n", "should have speed_mps", "0.44704"),
        ("time_s,speed\n0,0\n", "should have speed_mps", "did you mean speed_mps"),
        ("time_s;speed_mps\n0;0\n", "should have time_s and speed_mps", "by commas"),
        ("time_s,time_s,speed_mps\n0,0,0\n", "should have time_s once: 2", ""),
        (HEAD + "0,0\n1,fast\n", "line 3: speed_mps should be a number: 'fast'", ""),
        (HEAD + "0,0\n,1\n", "line 3: time_s should be a number: ''", ""),
        (HEAD + "0,0\n\n2,1\n1,1\n", "line 5: time_s should be greater", "sort"),
        (HEAD + "0,0\n1,nan\n", "line 3: speed should be finite: nan", ""),
        (HEAD + "0,0\n1,-2\n", "line 3: speed should be at least 0: -2", "backwards"),
        (HEAD + "0,0\n1\n", "line 3: should have 2 cells", ""),
        (HEAD + "0,0,1,5\n", "line 2: should have 2 cells", "decimals by a point"),
        (HEAD + "0,0\n1,130\n", "line 3: speed_mps should be at most 120", "km/h"),
    ],
)
def test_an_unsound_file_is_refused_by_name_line_and_mend(text, message, hint):
    with pytest.raises(InputError) as error:
        read_cycle(io.StringIO(text), "c.csv")
    assert str(error.value).startswith("c.csv: ")
    assert message in str(error.value)
    assert hint in error.value.hint


@pytest.mark.parametrize(("back", "stands"), [(0.0, True), (0.3, False)])
def test_a_measured_speed_whose_noise_is_below_nil_stands_there(back, stands):
    """And a car that rolls back is no noise."""
    time = np.arange(0.0, 40.0, 0.1)
    true = np.clip(np.minimum(time - 10.0, 35.0 - time), -back, 8.0)
    speed = true + np.random.default_rng(3).normal(0.0, 0.02, len(time))
    rows = "".join(f"{t:.1f},{v:.5f}\n" for t, v in zip(time, speed, strict=True))
    if not stands:
        with pytest.raises(InputError, match="line 2: speed should be at least 0"):
            read_cycle(io.StringIO(HEAD + rows), "c.csv")
        return
    cycle = read_cycle(io.StringIO(HEAD + rows), "c.csv")
    assert cycle.speed_mps == pytest.approx(np.maximum(speed, 0.0), abs=1e-5)
    assert f"{(speed < 0).sum()} rows of noise below 0 m/s" in cycle.source


@pytest.mark.parametrize("name", ["junk.csv", "junk.csv.gz"])
@pytest.mark.parametrize(
    "junk",
    [
        bytes(range(256)) * 100,
        b"\0" * 100_000,
        b"a" * 1_000_000,
        b'"' + b"a,\n" * 100_000,
        "time_s,speed_mps\n0,0\n".encode("utf-16"),
        gzip.compress(b"time_s,speed_mps\n0,0\n1,1\n" * 999)[:60],
    ],
    ids=["bytes", "zeros", "one-line", "open-quote", "utf-16", "cut-gzip"],
)
def test_binary_junk_is_an_input_error(name, junk, tmp_path):
    (tmp_path / name).write_bytes(junk)
    with pytest.raises(InputError, match=name):
        read_cycle(tmp_path / name)


@given(st.binary(max_size=300))
def test_no_bytes_at_all_cause_another_error_than_an_input_error(tmp_bytes):
    stream = io.TextIOWrapper(io.BytesIO(tmp_bytes), encoding="utf-8", newline="")
    with pytest.raises(InputError):
        read_cycle(stream, "c")


def test_a_line_without_end_is_not_read_to_its_end():
    class Endless(io.StringIO):
        taken = 0

        def readline(self, size=-1):
            assert size > 0
            self.taken += size
            return "x" * size

    stream = Endless()
    with pytest.raises(InputError, match="a line without end"):
        read_cycle(stream, "c")
    assert stream.taken < 1_000_000


# The user's words


@pytest.mark.parametrize(
    ("spec", "duration"),
    [
        ("udds", 1369),
        (" udds ", 1369),
        ("udds[20:125]", 105),
        ("udds[20:]", 1349),
        ("udds[:505]", 505),
        ("udds[:]", 1369),
        ("udds[1e+2:2.5e+2]", 150),
        ("udds*3", 3 * 1369),
        ("udds * 2", 2 * 1369),
        ("udds[0:505]*2", 1010),
        ("udds*2[0:2000]", 2000),
        ("udds[0:505]+hwfet", 505 + 765),
        ("udds + hwfet*2 + us06", 1369 + 2 * 765 + 600),
    ],
)
def test_words_make_a_cycle_of_their_length(spec, duration):
    assert named(spec).duration == pytest.approx(duration)


@pytest.mark.parametrize(
    "spec",
    [
        *("", " ", "+", "udds+", "udds[20]", "udds[a:b]", "udds[1:2:3]", "udds]"),
        *("udds*", "udds*2.5", "3*udds", "[1:2]", "udds[5:1]", "udds[nan:3]"),
        *("udds*0", "-+-", "/0.**", "udds.[", "udds.*"),
    ],
)
def test_words_without_sense_are_an_input_error(spec):
    with pytest.raises(InputError):
        parse_cycle(spec, io.StringIO(HEAD + "0,0\n1,1\n"), PLACES)


@given(st.text(alphabet="uds[]:*+-.0123 /e", max_size=12))
def test_no_words_cause_another_error_than_an_input_error(spec):
    with contextlib.suppress(InputError):
        parse_cycle(spec, io.StringIO(""), PLACES)


def test_an_unknown_name_lists_close_names_and_all_there_are():
    with pytest.raises(InputError, match="no such cycle: 'UDSS'") as error:
        named("UDSS")
    assert "did you mean `udds`" in error.value.hint
    assert all(name in error.value.hint for name in NAMES)


def test_stdin_is_a_cycle_that_can_be_cut_and_joined():
    text = HEAD + "0,0\n10,0\n"
    assert parse_cycle("-[2:5]", io.StringIO(text)).duration == 3
    assert parse_cycle("-+udds", io.StringIO(text), PLACES).duration == 10 + 1369
    with pytest.raises(InputError, match="stdin"):
        parse_cycle("-")


def test_a_path_is_read_even_if_its_name_holds_signs(tmp_path):
    path = tmp_path / "a+b*2[1].csv"
    path.write_text(HEAD + "0,0\n10,5\n")
    assert parse_cycle(str(path)).duration == 10
    plain = path.rename(tmp_path / "plain.csv")
    assert parse_cycle(f"{plain}[2:5]").duration == 3
    with pytest.raises(InputError, match=r"none\.csv: no such file"):
        parse_cycle(str(tmp_path / "none.csv"))
    with pytest.raises(InputError, match="it is a folder"):
        parse_cycle(f"{tmp_path}/")


def test_a_cycle_says_where_its_figures_come_from(tmp_path):
    assert "EPA" in named("udds").source
    (tmp_path / "mine.csv").write_text(HEAD + "0,0\n1,1\n")
    mine = parse_cycle("mine", places=[Place(tmp_path, "user folder")])
    assert (mine.name, mine.source) == ("mine", "user folder: mine.csv")


def test_the_listing_holds_every_shipped_cycle():
    assert [entry.name for entry in list_cycles(PLACES)] == NAMES
