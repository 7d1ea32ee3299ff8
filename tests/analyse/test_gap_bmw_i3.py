"""The shipped BMW i3 against trips that its figures were never fitted to."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.vehicle import load_vehicle

TRIPS = Path(__file__).resolve().parents[3] / "shared/data/real_ev/bmw_i3_tum"
JUDGED = ("TripB16", "TripB17", "TripB18", "TripB19")

pytestmark = pytest.mark.skipif(not TRIPS.is_dir(), reason="the BMW logs are not here")


def electrical_percent(trip: str, hide: tuple[str, ...] = ()) -> float:
    car = load_vehicle("bmw_i3")
    found = gap(open_log(TRIPS / f"{trip}.csv.gz", car, hide=hide), car)
    stages = {stage.stage: stage.gap_wh for stage in found.stages}
    assert found.energy.measured_wh
    return 100 * stages["electrical"] / found.energy.measured_wh


@pytest.mark.parametrize("trip", JUDGED)
def test_logged_torque_gives_the_battery_energy_within_3_percent(trip):
    source = load_vehicle("bmw_i3").effects["motor_efficiency"]["scale"].source
    assert trip not in source
    assert abs(electrical_percent(trip)) <= 3.0


@pytest.mark.parametrize("trip", JUDGED)
def test_without_the_logged_auxiliaries_it_falls_12_to_25_percent_short(trip):
    assert 12.0 <= electrical_percent(trip, hide=("aux_power_w",)) <= 25.0
