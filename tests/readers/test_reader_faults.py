"""What is no log, or a broken one, is said in one line: never a number of it."""

from __future__ import annotations

import gzip
import subprocess
import sys
import time

import numpy as np
import pytest

from rcc_sim.errors import InputError
from rcc_sim.readers import read_log
from rcc_sim.readers.reach import reach
from rcc_sim.trace import read_trace
from tests.readers import making


def refused(path, *words, **options):
    """Assert that a file is refused, naming it and these words."""
    with pytest.raises(InputError) as caught:
        read_log(path, **options)
    message = str(caught.value)
    assert str(path) in message
    for word in words:
        assert word in message, message
    return caught.value


def text(tmp_path, content, name="log.csv"):
    path = tmp_path / name
    path.write_text(content)
    return path


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", ["empty"]),
        ("\n \n", ["empty"]),
        ("time_s,speed_mps\n", ["no rows"]),
        ("time_s,speed_mps\n0,1\n", ["one row"]),
        ("time_s\n0\n1\n", ["no channel"]),
        ("time_s,speed_mps\n0,\n1,nan\n", ["every channel is blank"]),
        ("time_s,speed_mps\n,1\n,2\n", ["time_s", "blank"]),
        ("speed,current\n1,2\n3,4\n", ["time_s", "no shipped column map"]),
        ("Dear Sir or Madam\nhow are you\n", ["not a log"]),
        ("time_s,speed_mps\n0,1\n1,fast\n2,3\n", ["speed_mps", "row 2", "'fast'"]),
        ("time_s,speed_mps\n0,1\n1,2,3\n2,3\n", ["row 2", "2 fields", "3"]),
        ("time_s,speed_mps\n0,1\n1\n2,3\n", ["row 2", "2 fields", "1"]),
        ("time_s,speed_mps,speed_mps\n0,1,2\n1,2,3\n", ["speed_mps", "twice"]),
        ("time_s;speed_mps\n0.5;1,5\n1.5;2,5\n", ["speed_mps", "row 1", "'1,5'"]),
    ],
)
def test_a_bad_table_names_file_row_and_column(tmp_path, content, words):
    refused(text(tmp_path, content), *words)


def test_a_header_that_lacks_a_name_of_a_shipped_map_is_told_which(tmp_path):
    header = "ms_today;input_voltage;current_motor;erpm"
    path = text(tmp_path, header + "\n1;2;3;4\n2;2;3;4\n")
    hint = refused(path, "no shipped column map").hint
    assert "--map vesc_tool, whose header it has but for current_in" in hint
    assert len(read_log(path, columns="vesc_tool").trace) == 2


def test_a_word_far_down_is_found(tmp_path):
    rows = [f"{k},{k}" for k in range(300_000)]
    rows[290_000] = "290000,oops"
    path = text(tmp_path, "time_s,speed_mps\n" + "\n".join(rows))
    refused(path, "speed_mps", "row 290001", "'oops'")


def test_a_last_row_that_is_cut_short_is_left_out_and_said(tmp_path):
    log = read_log(text(tmp_path, "time_s,speed_mps,throttle\n0,1,0\n1,2,0\n2,3"))
    assert len(log.trace) == 2
    assert [flaw.kind for flaw in log.flaws] == ["cut_short"]
    assert "row (3)" in log.flaws[0].what


@pytest.mark.parametrize(
    ("column", "kinds"),
    [("foo", ["unknown", "nothing_known"]), ("speed_kmh", [])],
)
def test_a_log_of_which_nothing_is_known_says_so(tmp_path, column, kinds):
    rows = "\n".join(f"{0.1 * k},{k}" for k in range(20))
    flaws = read_log(text(tmp_path, f"time_s,{column}\n{rows}\n")).flaws
    assert [flaw.kind for flaw in flaws] == kinds


def test_a_file_that_is_not_there_or_a_plain_folder_is_refused(tmp_path):
    refused(tmp_path / "none.csv", "No such file")
    refused(tmp_path, "not a log")


@pytest.mark.parametrize("size", [5000, 200_000])
def test_random_bytes_are_refused(tmp_path, size):
    path = tmp_path / "noise.csv"
    path.write_bytes(np.random.default_rng(1).bytes(size))
    refused(path, "not a log")


def test_two_gigabytes_of_zeros_are_refused_at_once(tmp_path):
    path = tmp_path / "zeros.csv"
    with path.open("wb") as file:
        file.truncate(2 << 30)
    start = time.perf_counter()
    refused(path, "nothing but zeros")
    with pytest.raises(InputError, match="nothing but zeros"):
        read_trace(path)
    assert time.perf_counter() - start < 2


@pytest.mark.slow
def test_a_zip_bomb_is_refused_early_and_the_program_ends(tmp_path):
    path = tmp_path / "bomb.csv.gz"
    with gzip.open(path, "wb") as file:
        file.write(b"time_s,speed_mps\n")
        block = b"0,0\n" * (1 << 18)
        for _ in range(600):
            file.write(block)
    for command in (["convert"], ["energy"]):
        words = [sys.executable, "-m", "rcc_sim", *command, str(path)]
        done = subprocess.run(words, capture_output=True, text=True, timeout=60)
        assert done.returncode == 2
        assert "error: " in done.stderr and "250 times" in done.stderr
        assert done.stdout == ""


def test_a_truncated_gzip_is_refused(tmp_path):
    rows = "".join(f"{k},{np.sin(k)}\n" for k in range(50_000))
    packed = gzip.compress(("time_s,speed_mps\n" + rows).encode())
    path = tmp_path / "log.csv.gz"
    path.write_bytes(packed[: len(packed) // 2])
    refused(path, "cut short")
    with pytest.raises(InputError, match="cut short"):
        read_trace(path)
    path.write_bytes(packed[:300] + b"garbage" + packed[310:])
    refused(path, "gzip")


# Bags, MDF and Parquet


@pytest.mark.parametrize("part", [0.001, 0.02, 0.3, 0.7, 0.999])
@pytest.mark.parametrize("kind", ["bag", "mcap", "db3", "mf4", "parquet"])
def test_a_binary_log_that_is_cut_short_is_refused_or_read_true(tmp_path, kind, part):
    whole = made(tmp_path, kind)
    true = read_log(whole).trace
    cut = tmp_path / f"cut.{kind}"
    data = whole.read_bytes()
    cut.write_bytes(data[: int(part * len(data))])
    try:
        found = read_log(cut).trace
    except InputError as error:
        assert str(cut) in str(error)
        return
    for name, values in found.columns.items():  # what is read is the whole truth
        np.testing.assert_array_equal(values, true[name])


@pytest.mark.parametrize("kind", ["bag", "mcap", "db3", "mf4", "parquet"])
def test_a_binary_log_with_noise_in_it_never_ends_in_a_traceback(tmp_path, kind):
    data = made(tmp_path, kind).read_bytes()
    random = np.random.default_rng(7)
    for trial in range(6):
        bad = bytearray(data)
        for place in random.integers(20, len(bad), 40):
            bad[place] = random.integers(256)
        path = tmp_path / f"bad{trial}.{kind}"
        path.write_bytes(bad)
        try:
            log = read_log(path)
        except InputError as error:
            assert str(path) in str(error)
        else:
            assert len(log.trace) > 1


def made(folder, kind):
    """A sound log of a format."""
    if kind == "mf4":
        asammdf = pytest.importorskip("asammdf")
        with asammdf.MDF(version="4.10") as file:
            file.append([asammdf.Signal(making.SPEED, making.TIME, name="speed_mps")])
            file.save(folder / "log.mf4")
        return folder / "log.mf4"
    if kind == "parquet":
        from rcc_sim.trace import Trace, write_parquet

        trace = Trace({"time_s": making.TIME, "speed_mps": making.SPEED})
        with (folder / "log.parquet").open("wb") as file:
            write_parquet(trace, file)
        return folder / "log.parquet"
    store = making.stores()[0]
    if kind == "bag":
        bag = making.write_bag(folder / "a", store, start_ns=10**18)
        return making.convert_bag(bag, folder / "log.bag")
    bag = making.write_bag(folder / "a", store, "MCAP" if kind == "mcap" else "SQLITE3")
    (file,) = bag.glob(f"*.{kind}")
    return file


@pytest.mark.parametrize(
    ("kind", "words"), [("bag", "whole up to byte"), ("mcap", ""), ("db3", "pages")]
)
def test_a_bag_that_is_cut_off_says_how_far_it_is_whole(tmp_path, kind, words):
    whole = made(tmp_path, kind)
    size = whole.stat().st_size
    assert reach(whole) == ""
    part = tmp_path / f"part.{kind}"
    part.write_bytes(whole.read_bytes()[: size // 2])
    said = reach(part)
    assert words in said
    if kind != "db3":
        end = int(said.split()[4])
        assert 0 < end <= size // 2
        assert f"of {size // 2}" in said


def test_decimal_commas_are_read_and_said(tmp_path):
    point = read_log(text(tmp_path, "time_s,speed_mps\n0,1.5\n0.5,2.25\n1,3\n"))
    commas = "time_s;speed_mps\n0;1,5\n0,5;2,25\n1;3\n"
    comma = read_log(text(tmp_path, commas))
    for name in ("time_s", "speed_mps"):
        assert (comma.trace[name] == point.trace[name]).all()
    assert any("decimal ','" in note for note in comma.notes)


def test_an_unknown_message_is_said_and_the_rest_is_read(tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer

    store = making.stores()[0]
    with Writer(
        tmp_path / "bag", version=8, storage_plugin=StoragePlugin.SQLITE3
    ) as bag:
        odd = bag.add_connection(
            "/commands/motor/speed",
            "some_lab/msg/Speed",
            msgdef="float64 value",
            rihs01="RIHS01_" + "0" * 64,
        )
        kind = "nav_msgs/msg/Odometry"
        odom = bag.add_connection("/odom", kind, typestore=store)
        for k in range(10):
            message = making.filled(store, kind, **{"twist.twist.linear.x": float(k)})
            bag.write(odd, k * 10**8, b"\0\1\0\0" + bytes(8))
            bag.write(odom, k * 10**8, store.serialize_cdr(message, kind))
    making.without_definitions(tmp_path / "bag")
    log = read_log(tmp_path / "bag")
    np.testing.assert_array_equal(log.trace["speed_mps"], np.arange(10))
    assert "motor_speed_ref_erpm" not in log.trace
    assert any("some_lab/msg/Speed" in flaw.what for flaw in log.flaws)
    assert "/commands/motor/speed" in log.dropped


def test_a_bag_without_a_known_topic_lists_what_it_has(tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer

    store = making.stores()[0]
    with Writer(tmp_path / "bag", version=8, storage_plugin=StoragePlugin.MCAP) as bag:
        kind = "std_msgs/msg/Float64"
        link = bag.add_connection("/temperature", kind, typestore=store)
        message = making.filled(store, kind, data=1.0)
        bag.write(link, 1, store.serialize_cdr(message, kind))
    error = refused(tmp_path / "bag", "no topic")
    assert "/temperature" in error.hint


def test_a_missing_library_is_named_with_what_to_install(tmp_path, monkeypatch):
    path = tmp_path / "log.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + bytes(50))
    monkeypatch.setitem(sys.modules, "rosbags.highlevel.anyreader", None)
    error = refused(path, "rosbags", "not installed")
    assert error.hint == "pip install 'rccsim[ros]'"
    path = tmp_path / "log.mf4"
    path.write_bytes(b"MDF     4.10    " + bytes(500))
    monkeypatch.setitem(sys.modules, "asammdf", None)
    assert refused(path, "asammdf").hint == "pip install 'rccsim[mf4]'"


# Maps


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("[columns", ["TOML"]),
        ("[map]\n", ["columns", "missing"]),
        ('[columns]\nspeed_mps = "none"\n', ["speed_mps", "the file has no 'none'"]),
        ('[columns]\nspeed_mps = { from = "v", times = "i" }\n', ["has no 'i'"]),
        ('[columns]\nspeed_mps = { form = "v" }\n', ["form", "no such key"]),
        ('[columns]\nspeed_mps = { from = "v", unit = "kW" }\n', ["kW", "m/s"]),
        ('[columns]\nspeed_mps = { from = "v", unit = "kmh" }\n', ["'kmh'"]),
        ('[columns]\nspeed_mps = { from = "v", sign = 2 }\n', ["sign", "2"]),
        ('[columns]\nspeed_mps = { from = "v", factor = "x" }\n', ["factor", "'x'"]),
        ('[columns]\nspeed_mps = { from = "v", optional = 1 }\n', ["true or false"]),
        ('[columns]\n"Speed" = "v"\n', ["lower_snake_case"]),
        ('[columns]\nspeed = "v"\n', ["columns.speed", "should end in its unit"]),
        ('[columns]\nspeed_mps = "v"\n[map]\nencoding = "klingon"\n', ["klingon"]),
        ('[map]\ncarry_tenths = 1\n[columns]\nspeed_mps = "v"\n', ["carry_tenths"]),
        ('[columns]\nspeed_mps = "v"\n', ["no time column"]),
    ],
)
def test_a_bad_map_names_the_key(tmp_path, content, words):
    log = text(tmp_path, "t,v\n0,1\n1,2\n")
    by = text(tmp_path, content, "map.toml")
    with pytest.raises(InputError) as caught:
        read_log(log, columns=by)
    for word in words:
        assert word in str(caught.value)


def test_a_log_goes_without_a_column_that_its_map_calls_optional(tmp_path):
    by = text(
        tmp_path,
        '[columns]\ntime_s = "t"\nspeed_mps = "v"\n'
        'elevation_m = { from = ["alt", "baro"], optional = true }\n'
        'battery_power_w = { from = "v", times = "i", optional = true }\n'
        "[columns.aux_power_w]\n"
        'sum = [{ from = "heater" }, { from = "ac", optional = true }]\n',
        "map.toml",
    )
    both = read_log(
        text(tmp_path, "t,v,baro,heater,ac\n0,1,7,2,3\n1,2,8,4,5\n"), columns=by
    )
    assert both.trace["elevation_m"].tolist() == [7.0, 8.0]
    assert both.trace["aux_power_w"].tolist() == [5.0, 9.0]
    less = read_log(text(tmp_path, "t,v,heater\n0,1,2\n1,2,4\n"), columns=by)
    assert list(less.trace.columns) == ["time_s", "speed_mps"]
    assert any("elevation_m: no alt: left out" in note for note in less.notes)
    assert any("aux_power_w: no ac: left out" in note for note in less.notes)
    assert [note for note in less.notes if "battery_power_w" in note] == [
        "battery_power_w: no i, which it is multiplied by: left out"
    ]
    with pytest.raises(InputError, match="no 'heater'") as caught:
        read_log(text(tmp_path, "t,v,ac\n0,1,2\n1,2,4\n"), columns=by)
    assert "optional = true" in caught.value.hint


def test_an_unknown_reader_or_map_lists_those_there_are(tmp_path):
    path = text(tmp_path, "time_s,speed_mps\n0,1\n1,2\n")
    with pytest.raises(InputError, match="no such reader") as caught:
        read_log(path, reader="dbase")
    assert "ros2" in caught.value.hint
    with pytest.raises(InputError, match="no such column map") as caught:
        read_log(path, columns="none.toml")
    assert "bmw_i3_tum" in caught.value.hint


@pytest.mark.parametrize("name", ["ros1", "ros2", "mf4", "parquet", "vesc_tool"])
def test_a_forced_reader_of_the_wrong_format_says_so(tmp_path, name):
    refused(text(tmp_path, "time_s,speed_mps\n0,1\n1,2\n"), reader=name)
