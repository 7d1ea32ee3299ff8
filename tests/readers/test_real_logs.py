"""Real logs, where they lie beside the checkout: units and signs hold by physics."""

from __future__ import annotations

import gzip
import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from rcc_sim.errors import InputError
from rcc_sim.readers import on_one_clock, read_log
from tests.program import rccsim
from tests.readers.making import convert_bag

DATA = Path(__file__).resolve().parents[2].parent / "shared" / "data"
ABSENT = not DATA.is_dir()
pytestmark = pytest.mark.skipif(ABSENT, reason="the real logs are not beside us")

NO_LOG = {".md", ".mat", ".xlsx", ".upstream"}
NO_SERIES = ("epa_2022_test_car_list_electric.csv", "trip_quality.csv")


def files(*patterns):
    found = [p for pattern in patterns for p in sorted(DATA.glob(pattern))]
    return [p for p in found if p.is_file()]


LOGS = [
    path
    for path in files("real_rc/**/*", "real_ev/**/*")
    if path.suffix not in NO_LOG and path.name not in NO_SERIES
]
I3 = files("real_ev/bmw_i3_tum/Trip*.csv.gz")
TWIZY = files("real_ev/twizy_rsk/*.csv.gz")
NIGEL = files("real_rc/nigel_autodrive_1to14/*.bag.gz")
DART_STEPS = files("real_rc/dart_jetracer/1*_step_input*/*.csv")
DART_VICON = files(
    "real_rc/dart_jetracer/81_*/*.csv.gz", "real_rc/dart_jetracer/battery_pair/*.csv.gz"
)

read = cache(read_log)


def name(path):
    return path.name


def lines(path):
    """Rows of a text file, counted without any reader of ours."""
    raw = path.read_bytes()
    raw = gzip.decompress(raw) if path.suffix == ".gz" else raw
    return sum(1 for line in raw.splitlines() if line.strip()) - 1


@pytest.mark.parametrize("path", LOGS, ids=name)
def test_every_row_of_every_log_is_read_and_no_size_is_absurd(path):
    log = read(path)
    trace = log.trace
    if ".bag" not in path.name:
        assert len(trace) == lines(path)
    sizes = {
        "speed_mps": 50,
        "accel_x_mps2": 25,
        "accel_y_mps2": 30,
        "yaw_rate_radps": 15,
        "throttle": 1,
        "steering": 1,
        "battery_voltage_v": 420,
        "battery_current_a": 420,
        "motor_torque_nm": 260,
        "aux_power_w": 40_000,
        "slope": 1,
    }
    for column, most in sizes.items():
        if column in trace:
            assert np.nanmax(np.abs(trace[column])) <= most, column
    assert 2 < np.nanmax(trace["time_s"]) - np.nanmin(trace["time_s"]) < 4 * 3600


@pytest.mark.parametrize("file", NO_SERIES)
def test_a_table_that_is_no_log_is_refused(file):
    (path,) = files(f"real_ev/*/{file}")
    with pytest.raises(InputError, match="no time_s column"):
        read_log(path)


@pytest.mark.parametrize(
    "path",
    [p for p in files("real_rc/**/*", "real_ev/**/*") if p.suffix in NO_LOG],
    ids=name,
)
def test_a_file_that_is_no_table_is_refused(path):
    with pytest.raises(InputError, match=r"not a log|no time_s column"):
        read_log(path)


# BMW i3


# B02 logs current and heater spikes that cannot be (its table calls it "bad")
@pytest.mark.parametrize("path", [p for p in I3 if "B02" not in p.name], ids=name)
def test_the_i3s_charge_drawn_is_the_packs_share_that_the_car_counts(path):
    trace = read(path).trace
    charge = np.trapezoid(trace["battery_current_a"], trace["time_s"]) / 3600
    share = trace["state_of_charge_percent"]
    share = share[np.isfinite(share)]
    drawn = share[0] - share[-1]
    assert charge > 0  # discharging is positive
    # 60 A h nominal; 61 to 62 A h per 100 % in these files, the share to 0.1 to 0.5 %
    assert charge == pytest.approx(0.615 * drawn, abs=0.6 * 0.5)


@pytest.mark.parametrize("path", I3, ids=name)
def test_the_i3s_trip_is_as_its_table_says(path):
    rows = (DATA / "real_ev/bmw_i3_tum/trip_quality.csv").read_text().splitlines()
    head, *rest = [row.split(",") for row in rows]
    trip = dict(
        zip(head, next(r for r in rest if path.name.startswith(r[0])), strict=0)
    )
    trace = read(path).trace
    power = trace["battery_voltage_v"] * trace["battery_current_a"]
    distance = np.trapezoid(trace["speed_mps"], trace["time_s"]) / 1000
    heater, cooler = float(trip["heater_LIN_mean_W"]), float(trip["aircon_mean_W"])
    assert distance == pytest.approx(float(trip["distance_km"]), abs=0.02)
    assert power.mean() == pytest.approx(float(trip["batt_power_mean_W"]), rel=1e-2)
    assert trace["aux_power_w"].mean() == pytest.approx(heater + cooler, abs=1.1)


@pytest.mark.parametrize("path", I3, ids=name)
def test_the_i3s_motor_pulls_when_the_battery_gives(path):
    trace = read(path).trace
    shaft = trace["motor_torque_nm"] * trace["speed_mps"] / 0.335 * 9.665
    drawn = trace["battery_voltage_v"] * trace["battery_current_a"]
    drawn = drawn - trace["aux_power_w"]
    assert np.corrcoef(shaft, drawn)[0, 1] > 0.96
    moving = trace["speed_mps"] > 3
    change = np.gradient(trace["speed_mps"], trace["time_s"])
    assert np.corrcoef(trace["accel_x_mps2"][moving], change[moving])[0, 1] > 0.5


# Twizy


@pytest.mark.parametrize("path", TWIZY, ids=name)
def test_the_twizy_goes_as_far_as_its_route_on_a_believable_charge(path):
    trace = read(path).trace
    time = trace["time_s"]
    assert (np.diff(time) > 0).mean() > 0.99
    distance = np.trapezoid(trace["speed_mps"], time) / 1000
    low, high = (36, 53) if path.name.startswith("T1") else (45, 62)
    assert low < distance < high
    share = trace["state_of_charge_percent"]
    used = 61 * (share[0] - share[-1]) / distance  # Wh/km of a nominal 6.1 kWh
    assert 50 < used < 120


# DART


def coasting():
    """Speed and deceleration wherever a step file's throttle was 0 for 0.3 s."""
    speeds, slowing = [], []
    for path in DART_STEPS:
        trace = read(path).trace
        v, t, throttle = trace["speed_mps"], trace["time_s"], trace["throttle"]
        for k in range(3, len(v) - 1):
            if (throttle[k - 3 : k + 2] <= 0).all() and v[k + 1] > 0.2:
                speeds.append(v[k])
                slowing.append((v[k - 1] - v[k + 1]) / (t[k + 1] - t[k - 1]))
    return np.array(speeds), np.array(slowing)


def test_dart_coasts_down_as_its_authors_model_says():
    speeds, slowing = coasting()
    found, published = [], []
    for v in (0.5, 1.0, 1.5, 2.0, 3.0):
        near = np.abs(speeds - v) < 0.25
        assert near.sum() > 10
        found.append(np.median(slowing[near]))
        friction = 1.2660 * np.tanh(7.666 * v) + 0.7393 * v - 0.1123 * v**2
        published.append(friction / 1.580)
    assert found == pytest.approx(published, rel=0.15)
    assert 1.0 <= found[0] <= found[-1] <= 1.7


@pytest.mark.parametrize("path", DART_STEPS[:26], ids=name)
def test_dart_says_that_its_battery_sensors_are_dead_and_keeps_the_imus_bias(path):
    log = read(path)
    assert {"voltage", "current"} <= set(log.dropped)
    assert sum(flaw.kind == "dead" for flaw in log.flaws) == 2
    still = log.trace["speed_mps"] == 0
    still &= log.trace["throttle"] <= 0
    bias = np.median(log.trace["accel_x_mps2"][still])
    assert -0.55 < bias < 0.15


@pytest.mark.parametrize("path", DART_VICON, ids=name)
def test_darts_encoder_and_gyro_agree_with_motion_capture(path):
    trace = read(path).trace
    known = np.isfinite(trace["speed_mps"])
    t = trace["time_s"][known]
    yaw = np.unwrap(trace["yaw_rad"][known])
    turned = np.trapezoid(trace["yaw_rate_radps"][known], t)
    assert turned == pytest.approx(yaw[-1] - yaw[0], rel=0.1)
    steps = np.hypot(np.diff(trace["x_m"][known]), np.diff(trace["y_m"][known]))
    path_length = steps[steps < 0.2].sum()
    # wheels slip in the tightest turns; motion-capture noise lengthens the path
    rolled = np.trapezoid(trace["speed_mps"][known], t)
    assert rolled == pytest.approx(path_length, rel=0.35)
    assert (np.sign(np.median(trace["steering"][known])) == np.sign(turned)).all()


# Nigel, VESC Tool, Drexel


@pytest.mark.parametrize("path", NIGEL, ids=name)
def test_nigels_speed_is_the_way_its_pose_goes(path):
    trace = on_one_clock(read(path).trace)
    x, y, yaw = trace["x_m"], trace["y_m"], trace["yaw_rad"]
    ahead = np.diff(x) * np.cos(yaw[:-1]) + np.diff(y) * np.sin(yaw[:-1])
    went = np.trapezoid(trace["speed_mps"], trace["time_s"])
    assert went == pytest.approx(ahead.sum(), rel=0.02)
    turned = np.trapezoid(trace["yaw_rate_radps"], trace["time_s"])
    assert turned == pytest.approx(yaw[-1] - yaw[0], abs=0.02)


def test_the_vesc_ride_keeps_its_power_and_its_counters():
    (path,) = files("real_rc/vesc_tool_csv/*.csv")
    trace = read(path).trace
    assert 28 < np.ptp(trace["time_s"]) < 32
    given = trace["battery_voltage_v"] * trace["battery_current_a"]
    foc = 1.5 * (
        trace["voltage_d_v"] * trace["current_d_a"]
        + trace["voltage_q_v"] * trace["current_q_a"]
    )
    assert np.corrcoef(given, foc)[0, 1] > 0.95  # a second witness of the power
    rows = [line.split(";") for line in path.read_text().splitlines()]
    used, charged = (rows[0].index(f"watt_hours_{w}") for w in ("used", "charged"))
    counted = float(rows[-1][used]) - float(rows[1][used])
    counted -= float(rows[-1][charged]) - float(rows[1][charged])
    energy = np.trapezoid(given, trace["time_s"]) / 3600
    assert energy == pytest.approx(counted, rel=0.05)
    tacho = rows[0].index("tacho_meters")
    went = float(rows[-1][tacho]) - float(rows[1][tacho])
    rolled = np.trapezoid(trace["speed_mps"], trace["time_s"])
    assert rolled == pytest.approx(went, rel=0.03)


@pytest.mark.parametrize(
    ("file", "turns"), [("10", 12.7), ("15", 18.7)], ids=["log-10", "log-15"]
)
def test_the_drexel_car_reaches_a_wheel_speed_of_its_table(file, turns):
    path = DATA / f"real_rc/drexel_f1tenth/car-modeling/log-{file}.csv"
    trace = read(path).trace
    wheel = trace["motor_speed_radps"] / 4.5 / (2 * np.pi)
    assert 0.6 * turns < np.percentile(wheel, 90) < 1.5 * turns
    assert np.median(trace["accel_x_mps2"][:30]) == pytest.approx(-0.54, abs=0.1)


# One drive by every route


@pytest.mark.parametrize(
    "path",
    [*NIGEL[:1], *files("real_rc/dart_jetracer/rosbag1/*.gz")],
    ids=name,
)
def test_a_real_bag_is_the_same_by_sqlite3_mcap_and_back(path, tmp_path):
    bag = tmp_path / "one.bag"
    bag.write_bytes(gzip.decompress(path.read_bytes()))
    sqlite = convert_bag(bag, tmp_path / "sqlite")
    mcap = convert_bag(sqlite, tmp_path / "mcap", "mcap")
    back = convert_bag(mcap, tmp_path / "back.bag")
    first = read(path).trace
    for route in (bag, sqlite, mcap, *mcap.glob("*.mcap"), back):
        found = read_log(route).trace
        assert found.columns.keys() == first.columns.keys()
        for column, values in first.columns.items():
            np.testing.assert_array_equal(found[column], values)


@pytest.mark.parametrize("path", [*I3[:1], *I3[-1:]], ids=name)
def test_a_real_trip_is_the_same_by_mf4(path, tmp_path):
    asammdf = pytest.importorskip("asammdf")
    first = read(path).trace
    with asammdf.MDF(version="4.10") as file:
        signals = [
            asammdf.Signal(values, first["time_s"], name=column)
            for column, values in first.columns.items()
            if column != "time_s"
        ]
        file.append(signals)
        file.save(tmp_path / "trip.mf4")
    found = read_log(tmp_path / "trip.mf4").trace
    for column, values in first.columns.items():
        np.testing.assert_array_equal(found[column], values)


def test_the_json_of_convert_is_json(tmp_path):
    (path,) = files("real_rc/vesc_tool_csv/*.csv")
    done = rccsim("convert", path, "--json")
    assert json.loads(done.stdout)["rows"] == 400
