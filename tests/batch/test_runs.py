"""Many runs in one loop against the same runs one by one, and against laws."""

from __future__ import annotations

import numpy as np
import pytest

from rcc_sim.batch.batch import rows_of
from rcc_sim.batch.plan import Axis, Plan, make_plan
from rcc_sim.batch.results import LIMITS
from rcc_sim.batch.runs import Manoeuvre, Sweep
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.units import J_PER_WH
from tests.cars import car, truck

DRIVE = parse_cycle("udds[20:60]")


def swept(vehicle, cycle, settings, **how):
    """Return the rows of a sweep."""
    import pyarrow

    sweep = Sweep(vehicle, cycle, make_plan(settings), Manoeuvre(**how))
    sweep.check()
    return pyarrow.concat_tables(rows_of(sweep)).to_pylist()


def agree(row, run):
    """Hold a row to a single run: the same bits."""
    assert row["error"] is None
    trace, joules = run.trace, run.ledger
    assert row["distance_m"] == trace["distance_m"][-1]
    inside = joules.get("battery_resistance", 0.0)
    assert row["energy_wh"] == (run.battery_energy - inside) / J_PER_WH
    for sink, energy in joules.items():
        assert row[f"energy_{sink}_wh"] == energy / J_PER_WH
    power = trace["battery_power_w"]
    assert row["max_battery_power_w"] == power[1:].max()
    assert row["min_battery_power_w"] == power[1:].min()
    assert row["max_motor_torque_nm"] == trace["motor_torque_nm"][1:].max()
    assert row["max_accel_y_mps2"] == np.abs(trace["accel_y_mps2"]).max()
    assert row["max_yaw_rate_radps"] == np.abs(trace["yaw_rate_radps"]).max()


@pytest.mark.parametrize("imposed", [True, False], ids=["imposed", "commanded"])
@pytest.mark.parametrize("name", ["rcc", "r1t_epa", "f1tenth", "bmw_i3"])
def test_a_row_is_the_single_run_to_the_last_bit(name, imposed):
    vehicle = load_vehicle(name)
    small = vehicle.body.mass_kg.value < 100
    cycle = Cycle("slow", DRIVE.time_s, DRIVE.speed_mps * (0.2 if small else 1.0))
    m = vehicle.body.mass_kg.value
    lanes = LaneChanges(20.0 if small else 60.0)
    if not imposed and vehicle.controller.mode == "throttle":
        pytest.skip("a throttle follows no cycle")
    rows = swept(
        vehicle,
        cycle,
        [f"body.mass_kg={m},{1.1 * m}", f"lanes.every=none,{lanes.every}"],
        imposed=imposed,
    )
    for row in rows:
        single = simulate(
            vehicle.changed(settings={"body.mass_kg": row["body.mass_kg"]}),
            cycle,
            imposed=imposed,
            lanes=None if np.isinf(row["lanes.every"]) else lanes,
            engine="compiled",
        )
        agree(row, single)


def test_a_run_leaves_no_trace_in_the_next():
    effects = {
        "actuation_delay": {"delay_s": 0.05},
        "steering_delay": {"delay_s": 0.03},
        "steering_backlash": {"width_rad": 0.02},
        "tyre_relaxation": {"length_m": 0.1},
        "motor_lag": {"time_constant_s": 0.05},
    }
    slow = Cycle("slow", DRIVE.time_s, 0.2 * DRIVE.speed_mps)
    lanes = LaneChanges(20.0)
    settings = ["body.mass_kg=3:4:0.25"]
    forward = swept(car(effects), slow, settings, lanes=lanes)
    alone = [
        swept(car(effects), slow, [f"body.mass_kg={m}"], lanes=lanes)[0]
        for m in (3, 3.25, 3.5, 3.75, 4)
    ]
    assert [{**row, "run": 0} for row in forward] == alone


def test_scaling_the_cycle_is_driving_the_scaled_cycle():
    rows = swept(
        car(),
        DRIVE,
        ["cycle.speed_scale=0.1,0.2", "cycle.time_scale=0.5,1"],
        lanes=LaneChanges(20.0),
    )
    for row in rows:
        cycle = Cycle(
            "scaled",
            DRIVE.time_s * row["cycle.time_scale"],
            DRIVE.speed_mps * row["cycle.speed_scale"],
        )
        agree(row, simulate(car(), cycle, lanes=LaneChanges(20.0)))


def test_another_loop_rate_changes_the_rows_as_a_single_run_would():
    slow = Cycle("slow", DRIVE.time_s, 0.2 * DRIVE.speed_mps)
    for row in swept(car(), slow, ["controller.loop_rate_hz=200,500,1000"]):
        rate = row["controller.loop_rate_hz"]
        agree(row, simulate(car(controller__loop_rate_hz=rate), slow))


def test_auxiliary_power_costs_exactly_its_time():
    rows = swept(
        truck(), DRIVE, ["effects.auxiliary_load.power_w=0:1000:250"], imposed=True
    )
    for row in rows:
        more = row["energy_wh"] - rows[0]["energy_wh"]
        power = row["effects.auxiliary_load.power_w"]
        assert more == pytest.approx(power * DRIVE.duration / J_PER_WH, rel=1e-9)


def test_the_ledger_of_each_row_sums_to_its_energy():
    rows = swept(
        load_vehicle("r1t_epa"),
        DRIVE,
        ["effects.battery_resistance.resistance_ohm=0,0.05", "body.mass_kg=3000,3300"],
        imposed=True,
    )
    outputs = set(LIMITS) | {"energy_wh", "distance_m"}
    for row in rows:
        assert outputs <= set(row) | {"max_motor_current_a"}
        sinks = [
            v for k, v in row.items() if k.startswith("energy_") and k[-4:-2] != "y"
        ]
        total = sum(sinks) - row["energy_wh"]
        inside = row["energy_battery_resistance_wh"]
        assert total == pytest.approx(row["energy_wh"] + inside, rel=1e-9)
        assert abs(row["ledger_left_open"]) < 1e-9


def test_a_run_that_asks_too_much_of_the_battery_is_a_row_with_its_error():
    settings = ["effects.battery_resistance.resistance_ohm=0.01,0.1,10"]
    rows = swept(truck(), DRIVE, settings, imposed=True)
    assert [row["error"] is None for row in rows] == [True, True, False]
    assert "most power that the battery can give" in rows[2]["error"]
    assert rows[2]["energy_wh"] is None
    inside = [row["energy_battery_resistance_wh"] for row in rows[:2]]
    assert inside[1] > 10 * inside[0]  # more current too, as the voltage sags


def test_a_bad_value_among_good_ones_is_a_row_and_a_bad_key_is_none():
    rows = swept(truck(), DRIVE, ["body.mass_kg=-5,3000,9e9"], imposed=True)
    assert [row["error"] is None for row in rows] == [False, True, False]
    with pytest.raises(InputError, match="no such key"):
        swept(truck(), DRIVE, ["body.mas_kg=1,2"], imposed=True)
    with pytest.raises(InputError, match="should be greater than 0"):
        swept(truck(), DRIVE, ["body.mass_kg=-1,-2"], imposed=True)


def test_parts_follow_from_the_plan_and_cover_it():
    many = Plan((Axis("body.mass_kg", tuple(np.linspace(3000, 3400, 5000))),))
    sweep = Sweep(truck(), DRIVE, many, Manoeuvre(imposed=True))
    ranges = [sweep.manifest.range(k) for k in range(sweep.manifest.parts)]
    runs = [run for start, stop in ranges for run in range(start, stop)]
    assert runs == list(range(5000))
    assert len(ranges) >= 16


def test_an_effect_of_ones_own_is_swept_like_any_other():
    from tests.simulate.test_own_effects import TRAILER

    effects = {"trailer": {"mass_kg": 0.5, "coefficient": 0.03}}
    own = car().changed(files=(str(TRAILER),), effects=effects)
    slow = Cycle("slow", DRIVE.time_s, 0.2 * DRIVE.speed_mps)
    settings = ["effects.trailer.mass_kg=0.5,1.0"]
    for row in swept(own, slow, settings, imposed=True):
        mass = row["effects.trailer.mass_kg"]
        changed = own.changed(settings={"effects.trailer.mass_kg": mass})
        agree(row, simulate(changed, slow, imposed=True, engine="compiled"))
        assert row["energy_trailer_wh"] > 0


def test_a_road_that_the_vehicles_file_names_is_driven(tmp_path):
    (tmp_path / "road.csv").write_text("distance_m,slope\n0,0.02\n1000,0.02\n")
    text = (
        '[vehicle]\nname = "hill"\nextends = "r1t_epa"\n'
        '[effects.road_grade]\nslope = 0.0\nprofile = "road.csv"\n'
    )
    (tmp_path / "hill.toml").write_text(text)
    hill = load_vehicle(tmp_path / "hill.toml")
    row = swept(hill, DRIVE, ["body.mass_kg=3000"], imposed=True)[0]
    height = 0.02 / np.hypot(1, 0.02) * row["distance_m"]
    assert row["energy_road_grade_wh"] == pytest.approx(
        3000 * 9.80665 * height / J_PER_WH, rel=1e-9
    )
