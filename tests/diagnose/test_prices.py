"""What a cause costs: prices and what is left sum to the gap."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.prices import prices, with_profiles
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.judged import leaves_a_gap
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import write_trace
from rcc_sim.units import J_PER_WH, G

ROLLS = Cause("rolling_resistance", ("effects.rolling_resistance.coefficient",), 50, 0)
DRAWS = Cause("auxiliary_load", ("effects.auxiliary_load.power_w",), 40, 0)
VALUES = {
    "effects.rolling_resistance.coefficient": 0.02,
    "effects.auxiliary_load.power_w": 5.0,
    "bias.0.battery_current_a": 0.1,
    "body.mass_kg": 3.7,
}


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    car = load_vehicle("rcc").changed(
        effects={
            "rolling_resistance": {"coefficient": 0.021},
            "auxiliary_load": {"power_w": 5.0},
        }
    )
    path = tmp_path_factory.mktemp("priced") / "log.csv"
    with path.open("wb") as file:
        write_trace(simulate(car, parse_cycle("udds[20:60]")).trace, file)
    return open_log(path, load_vehicle("rcc"))


@pytest.fixture(scope="module")
def plain(log):
    return problem_of(log.log, load_vehicle("rcc"))


def test_prices_and_what_is_left_sum_to_the_gap_that_gap_measures(log, plain):
    energy = gap(log, load_vehicle("rcc")).energy
    told = prices(plain, [ROLLS, DRAWS], VALUES)
    whole = sum(told.causes.values()) + told.figures_wh + told.unexplained_wh
    assert whole + told.meters_wh == pytest.approx(energy.gap_wh, rel=1e-9)


def test_what_another_drive_takes_is_told_apart(log, plain):
    """Prices, what is left and the other drive sum to the gap that was measured."""
    energy = gap(log, load_vehicle("rcc")).energy
    uphill = plain.on_road(np.array([0.0, 1e4]), np.array([0.01, 0.01]))
    told = prices(uphill, [ROLLS, DRAWS], VALUES, simulated=energy.simulated_wh)
    climbed = prices(uphill, [], {}).unexplained_wh
    assert told.drive_wh == pytest.approx(energy.gap_wh - climbed, rel=1e-9)
    lifted = plain.vehicle.body.mass_kg.value * G * 0.01 * plain.distance[-1] / J_PER_WH
    assert 1.0 < told.drive_wh / lifted < 1.2  # and the copper loss of doing it
    whole = sum(told.causes.values()) + told.figures_wh + told.unexplained_wh
    whole += told.meters_wh
    assert whole + told.drive_wh == pytest.approx(energy.gap_wh, rel=1e-9)


def test_a_constant_load_costs_its_power_times_the_time(log, plain):
    told = prices(plain, [DRAWS], VALUES)
    hours = float(np.ptp(log.log["time_s"])) / 3600
    assert told.causes["auxiliary_load"] == pytest.approx(5.0 * hours, rel=0.01)


def test_without_causes_all_is_figures_and_what_is_left(log, plain):
    told = prices(plain, [], {"bias.0.accel_x_mps2": 0.1})
    assert told.causes == {} and told.figures_wh == told.meters_wh == 0.0
    assert told.unexplained_wh == pytest.approx(gap(log, plain.vehicle).energy.gap_wh)


def test_what_a_meter_reads_too_much_is_no_part_of_what_is_left(log, plain):
    """By 0.1 A it reads u · 0.1 A too much, for as long as the drive takes."""
    told = prices(plain, [DRAWS], VALUES)
    time, volts = log.log["time_s"], log.log["battery_voltage_v"]
    power = 0.1 * np.trapezoid(volts, time) / J_PER_WH
    assert told.meters_wh == pytest.approx(power, rel=1e-3)


def test_prices_do_not_hang_on_the_order_of_the_causes(plain):
    one = prices(plain, [ROLLS, DRAWS], {k: VALUES[k] for k in list(VALUES)[:2]})
    two = prices(plain, [DRAWS, ROLLS], {k: VALUES[k] for k in list(VALUES)[:2]})
    for name, wh in one.causes.items():
        assert two.causes[name] == pytest.approx(wh, rel=1e-9)


@pytest.mark.parametrize(("power", "told"), [(5.0, True), (20_000.0, False)])
def test_what_no_battery_could_have_paid_is_no_price(plain, power, told):
    """As of a vehicle that, with one part of what was found alone, leaves the road."""
    values = VALUES | {"effects.auxiliary_load.power_w": power}
    assert (prices(plain, [DRAWS], values) is not None) == told


def test_a_load_that_varies_costs_its_mean(plain):
    ends = plain.log["time_s"][[0, -1]]
    ramp = Profile(
        DRAWS.keys[0], "time_s", ends, np.array([0.0, 10.0]), np.ones(2), 99.0
    )
    varying = Cause(DRAWS.effect, DRAWS.keys, 99, 0, profiles={0: ramp})
    told = prices(plain, [varying], {})
    flat = prices(plain, [DRAWS], {DRAWS.keys[0]: 5.0})
    assert told.causes["auxiliary_load"] == pytest.approx(
        flat.causes["auxiliary_load"], rel=0.01
    )
    assert with_profiles(plain, [DRAWS]) is plain


def test_a_log_without_energy_has_no_prices(plain):
    from dataclasses import replace

    from rcc_sim.trace import Trace

    kept = {c: plain.log[c] for c in ("time_s", "speed_ref_mps", "speed_mps")}
    assert prices(replace(plain, log=Trace(kept)), [], {}) is None


def with_doubt(found, share):
    """A gap whose uncertainty is a share of it."""
    doubt = share * abs(found.energy.gap_wh)
    return replace(found, energy=replace(found.energy, tolerance_wh=doubt))


def test_a_gap_that_causes_leave_to_stated_figures_is_told(log, plain):
    """All of it is the causes', or one that costs nothing leaves it to the figures."""
    found, fit = gap(log, load_vehicle("rcc")), SimpleNamespace(values=VALUES)
    idle = Cause("yaw_rate_bias", ("effects.yaw_rate_bias.bias_radps",), 50, 0)
    turns = SimpleNamespace(values=VALUES | {idle.keys[0]: 0.01})
    sure, doubted = with_doubt(found, 0.05), with_doubt(found, 0.5)
    assert leaves_a_gap(plain, sure, [idle], turns, 0)
    assert not leaves_a_gap(plain, sure, [ROLLS, DRAWS], fit, 0)
    assert not leaves_a_gap(plain, doubted, [idle], turns, 0)
    assert not leaves_a_gap(plain, sure, [], fit, 0)  # what is found is no cause
