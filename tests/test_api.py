"""What a script begins with."""

import inspect
import re

import pytest

from rcc_sim import api


def test_all_that_is_offered_is_there_and_says_what_it_is():
    """By a docstring of its own, and each function by the table of the module."""
    told = set(re.findall(r":(?:func|class):`(\w+)`", api.__doc__))
    for name in api.__all__:
        offered = getattr(api, name)
        assert inspect.getdoc(offered)
        assert name in told or not inspect.isfunction(offered)
    assert told <= set(api.__all__)


def test_a_vehicle_is_mended_by_what_its_log_tells(tmp_path):
    """By the names of the table alone: no command, no other import."""
    car, truck = api.load_vehicle("rcc"), api.load_vehicle("r1t")
    cycle = api.scale_cycle(api.parse_cycle("nycc[0:200]"), to=car, of=truck).cycle
    fed = car.changed(effects={"auxiliary_load": {"power_w": 6.0}})
    run = api.simulate(fed, cycle)
    with (tmp_path / "log.csv").open("wb") as file:
        api.write_trace(run.trace, file)
    found = api.diagnose([api.open_log(tmp_path / "log.csv", car)], car)
    assert [one.cause.effect for one in found.asserted] == ["auxiliary_load"]
    api.write_mended(found, tmp_path / "mended.toml")
    mended = api.load_vehicle(str(tmp_path / "mended.toml"))
    power = mended.effects["auxiliary_load"]["power_w"]
    assert power.value == pytest.approx(6.0, rel=0.02)
