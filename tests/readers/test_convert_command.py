"""`convert`, and the way out: what the car plays comes back as it was written."""

from __future__ import annotations

import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.errors import InputError
from rcc_sim.readers import plugins, read_log, with_vehicle, write_commands
from rcc_sim.trace import read_trace
from tests.program import rccsim
from tests.readers import making


class Car:
    """A car of 4 poles, gear 10, wheels of 50 mm."""

    where = "car"

    def __init__(self, poles=4):
        self.motor = SimpleNamespace(poles=poles)

    def figure(self, key, why=""):
        values = {"drivetrain.gear_ratio": 10.0, "tyres.radius_m": 0.05}
        return SimpleNamespace(value=values[key])


ERPM_PER_MPS = 10 / 0.05 * 60 / (2 * np.pi) * 2


# What the car plays


@pytest.mark.parametrize("form", ["mcap", "csv"])
def test_commands_come_back_by_our_own_reader(tmp_path, form):
    path = tmp_path / f"play.{form}"
    write_commands(path, making.TIME, making.SPEED, making.STEER, Car(), form)
    trace = read_log(path).trace
    single = np.float32 if form == "mcap" else float  # /drive holds 32 bit
    np.testing.assert_allclose(trace["time_s"], making.TIME, atol=1e-9)
    for name, values in (
        ("speed_ref_mps", making.SPEED),
        ("steer_cmd_rad", making.STEER),
    ):
        np.testing.assert_allclose(trace[name], values.astype(single), atol=1e-9)
    np.testing.assert_allclose(
        trace["motor_speed_ref_erpm"], making.SPEED * ERPM_PER_MPS, rtol=1e-9
    )


def test_a_played_bag_holds_the_two_topics_with_their_definitions(tmp_path):
    from rosbags.highlevel import AnyReader

    path = tmp_path / "play.mcap"
    write_commands(path, [0, 0.1], [1, 2], None, Car())
    with AnyReader([path]) as bag:  # no types are given: the file must carry them
        found = {c.topic: (c.msgtype, c.msgcount) for c in bag.connections}
        stamps = [stamp for _, stamp, _ in bag.messages()]
    assert found == {
        "/drive": ("ackermann_msgs/msg/AckermannDriveStamped", 2),
        "/commands/motor/speed": ("std_msgs/msg/Float64", 2),
    }
    assert stamps == [0, 0, 100_000_000, 100_000_000]


def test_a_played_bag_is_the_same_bytes_every_time_and_replaces_whole(tmp_path):
    path = tmp_path / "play.mcap"
    write_commands(path, making.TIME, making.SPEED, None, Car())
    first = path.read_bytes()
    write_commands(path, making.TIME, making.SPEED, None, Car())
    assert path.read_bytes() == first
    with pytest.raises(InputError, match="row 2"):
        write_commands(path, [0, 1], [1, np.nan], None, Car())
    assert path.read_bytes() == first
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("time", "speed", "car", "form", "words"),
    [
        ([0, 1], [1], Car(), "csv", "alike in length"),
        ([1, 0], [1, 1], Car(), "csv", "increase"),
        ([-1, 0], [1, 1], Car(), "csv", "increase"),
        ([0, 1], [1, 1], Car(poles=None), "csv", "motor.poles"),
        ([0, 1], [1, 1], Car(), "bag", "one of mcap, csv"),
    ],
)
def test_commands_that_make_no_sense_are_refused(
    tmp_path, time, speed, car, form, words
):
    with pytest.raises(InputError, match=words):
        write_commands(tmp_path / "play", time, speed, None, car, form)
    assert not list(tmp_path.iterdir())


def test_scale_cycle_writes_a_bag_at_the_rate_of_the_cars_reference(tmp_path):
    words = ["scale-cycle", "udds[20:60]", "--from", "r1t", "--to", "rcc"]
    done = rccsim(*words, "--format", "mcap", "-o", "play.mcap", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "")
    plain = rccsim(*words, "--rate", "100", "-o", "cycle.csv", cwd=tmp_path)
    assert plain.returncode == 0
    played = read_log(tmp_path / "play.mcap").trace
    cycle = read_trace(tmp_path / "cycle.csv")
    np.testing.assert_allclose(played["time_s"], cycle["time_s"], atol=1e-8)
    np.testing.assert_allclose(
        played["speed_ref_mps"], cycle["speed_mps"], atol=1e-6
    )  # 32 bit
    refused = rccsim(*words, "--format", "mcap", cwd=tmp_path)
    assert refused.returncode == 2 and "--output" in refused.stderr


# convert


def test_a_sign_that_a_map_turns_is_said_of_a_column_that_keeps_its_name(tmp_path):
    (tmp_path / "log.csv").write_text("time_s,battery_current_a\n0,-1\n1,-2\n")
    turned = 'battery_current_a = { from = "battery_current_a", sign = -1 }'
    (tmp_path / "turn.toml").write_text(f'[columns]\ntime_s = "time_s"\n{turned}\n')
    done = rccsim(
        "convert", "log.csv", "--map", "turn.toml", "-o", "b.csv", cwd=tmp_path
    )
    assert "battery_current_a from battery_current_a × -1" in done.stderr
    assert read_trace(tmp_path / "b.csv")["battery_current_a"].tolist() == [1.0, 2.0]


def test_convert_says_what_became_of_every_column(tmp_path):
    making.write_vesc(tmp_path / "ride.csv")
    done = rccsim("convert", "ride.csv", "-o", "ride.parquet", cwd=tmp_path)
    assert done.returncode == 0
    assert "mapped: battery_voltage_v from input_voltage" in done.stderr
    assert "guessed: accel_x_mps2" in done.stderr
    assert "dropped: " in done.stderr and "fault_code" in done.stderr
    report = json.loads(rccsim("convert", "ride.csv", "--json", cwd=tmp_path).stdout)
    kept = {row["source"] for row in report["mapped"]}
    header = set(making.VESC_HEADER.rstrip(";").split(";"))
    rows_only = {"ms_today_imu", "gnss_posTime"}  # they tell where IMU and GNSS lack
    assert kept | set(report["dropped"]) | rows_only == header
    assert report["rows"] == len(making.TIME)


def test_convert_gives_the_same_by_csv_gzip_parquet_and_pipe(tmp_path):
    making.write_vesc(tmp_path / "ride.csv")
    for name in ("a.csv", "a.csv.gz", "a.parquet"):
        assert rccsim("convert", "ride.csv", "-o", name, cwd=tmp_path).returncode == 0
    piped = rccsim("convert", "ride.csv", cwd=tmp_path).stdout
    assert piped == (tmp_path / "a.csv").read_text()
    again = rccsim("convert", "-", stdin=piped, cwd=tmp_path).stdout
    assert again == piped
    first = read_log(tmp_path / "ride.csv").trace
    for name in ("a.csv", "a.csv.gz", "a.parquet"):
        trace = read_trace(tmp_path / name)
        for column, values in first.columns.items():
            digits = 1e-9 * np.nanmax(np.abs(values), initial=0)  # ten of the largest
            np.testing.assert_allclose(trace[column], values, rtol=0, atol=digits)


def test_convert_refuses_to_write_csv_under_another_formats_name(tmp_path):
    making.write_vesc(tmp_path / "ride.csv")
    done = rccsim("convert", "ride.csv", "-o", "ride.mcap", cwd=tmp_path)
    assert done.returncode == 2 and "ride.mcap" in done.stderr
    assert not (tmp_path / "ride.mcap").exists()


def test_a_vehicle_turns_erpm_into_speed_and_replaces_nothing(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time_s,motor_speed_erpm\n0,0\n1,12000\n")
    log = with_vehicle(read_log(path), Car())
    assert log.trace["speed_mps"][1] == pytest.approx(12000 / ERPM_PER_MPS)
    assert log.trace["motor_speed_radps"][1] == pytest.approx(200 * np.pi)
    path.write_text("time_s,motor_speed_erpm,speed_mps\n0,0,0\n1,12000,9\n")
    assert with_vehicle(read_log(path), Car()).trace["speed_mps"][1] == 9


def test_poles_are_asked_for_only_where_they_matter(tmp_path):
    """A road speed follows from the motor's by gear and tyre alone."""
    path, car = tmp_path / "log.csv", Car(poles=None)
    path.write_text("time_s,motor_speed_radps\n0,0\n1,100\n")
    speed = with_vehicle(read_log(path), car).trace["speed_mps"]
    np.testing.assert_allclose(speed, [0, 100 * 0.05 / 10])
    path.write_text("time_s,motor_speed_erpm,speed_mps\n0,0,0\n1,12000,9\n")
    columns = with_vehicle(read_log(path), car).trace.columns
    assert "motor_speed_radps" not in columns and columns["speed_mps"][1] == 9
    path.write_text("time_s,motor_speed_erpm\n0,0\n1,12000\n")
    with pytest.raises(InputError, match=r"motor\.poles"):
        with_vehicle(read_log(path), car)


def test_convert_without_a_log_lists_readers_and_maps():
    rows = json.loads(rccsim("convert", "--json").stdout)
    names = {row["name"] for row in rows}
    assert {"rccsim", "ros1", "ros2", "mf4", "vesc_tool", "bmw_i3_tum"} <= names


def test_a_plugin_reader_is_asked_first(tmp_path, monkeypatch):
    from rcc_sim.readers import own

    class Reader:
        NAME = "theirs"
        SUMMARY = "begins with THEIRS"

        def sniff(self, source):
            return source.head.startswith(b"THEIRS")

        def read(self, source, columns=None):
            (tmp_path / "inner.csv").write_bytes(source.head.partition(b"\n")[2])
            return read_log(tmp_path / "inner.csv")

    point = SimpleNamespace(name="theirs", load=lambda: Reader())
    monkeypatch.setattr("importlib.metadata.entry_points", lambda group: [point])
    path = tmp_path / "log.dat"
    path.write_text("THEIRS\ntime_s,speed_mps\n0,1\n1,2\n")
    np.testing.assert_array_equal(read_log(path).trace["speed_mps"], [1, 2])
    assert plugins.named("rccsim") is own


@pytest.mark.slow
def test_ten_hours_at_100_hz_are_read_in_seconds_and_within_a_gigabyte(tmp_path):
    code = (
        "import sys, time, resource, numpy as np\n"
        "from rcc_sim.readers import read_log\n"
        "import pyarrow.csv\n"
        "peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6\n"
        "before, start = peak(), time.process_time()\n"
        "log = read_log(sys.argv[1])\n"
        "print(len(log.trace), time.process_time() - start, peak() - before)\n"
    )
    block = "".join(
        f"{k / 100:.2f},{np.sin(k):.5f},{np.cos(k):.5f},{k % 7}.5,12.1,0.33\n"
        for k in range(36_000)
    )
    path = tmp_path / "long.csv"
    with path.open("w") as file:
        file.write("time_s,speed_mps,yaw_rate_radps,battery_current_a,")
        file.write("battery_voltage_v,steer_cmd_rad\n")
        for _ in range(100):
            file.write(block)
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True
    )
    rows, seconds, gigabytes = (float(word) for word in done.stdout.split())
    assert rows == 3_600_000
    assert gigabytes < 1
    assert seconds < 30  # of processor time; 3 s on an idle machine
