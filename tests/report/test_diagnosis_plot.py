"""The figure of a diagnosis: how far energy ran off, and every panel of its page."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.prices import prices
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.report import diagnosis_plot
from rcc_sim.report.diagnosis_page import mended
from rcc_sim.report.sheet import head, sheet
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from tests.report.made import diagnosis_report


@pytest.fixture
def drawn(monkeypatch):
    """The axes of a diagnosis, by their labels, and its report."""
    report = diagnosis_report(36.0)
    time = report.measured["time_s"]
    load = np.where(time > 20.0, 9.0, 2.0)
    name = "auxiliary_load.power_w"
    course = {name: load, f"{name}_low": load - 1.0, f"{name}_high": load + 1.0}
    report = replace(report, profiles=Trace({"time_s": time, **course}))
    gap = SimpleNamespace(
        log="drive.csv",
        vehicle="rcc",
        measured=report.measured,
        simulated=report.before,
    )
    load_and = SimpleNamespace(
        cause=SimpleNamespace(effect="auxiliary_load", tied=("iron_loss",)),
        probability=0.97,
    )
    found = SimpleNamespace(gap=gap, asserted=[load_and], status="explained")
    monkeypatch.setattr(diagnosis_plot, "mended", lambda _: report.after)
    figure = diagnosis_plot.plot_diagnosis(found, report)
    assert (
        figure.get_suptitle()
        == "drive.csv against rcc: auxiliary_load or iron_loss 97 %"
    )
    return {a.get_ylabel(): a for a in figure.axes}, report


def test_the_energy_that_is_missing_is_drawn_as_it_adds_up(drawn):
    """Held against a sum of trapezia."""
    axes, report = drawn
    log, lines = report.measured, axes["Energy gap [Wh]"].get_lines()
    for line, run in zip(lines, (report.before, report.after), strict=True):
        off = log["battery_power_w"] - run["battery_power_w"]
        assert line.get_ydata()[-1] == pytest.approx(
            np.trapezoid(off, log["time_s"]) / 3600, rel=1e-9
        )


def test_every_channel_shows_the_three_and_what_varies_its_band(drawn):
    axes, report = drawn
    assert len(axes) == 1 + len(report.before.keys() - {"time_s"}) + 1
    speed = axes["Speed [m/s]"].get_lines()
    names = ["measured", "simulated as stated", "mended"]
    assert [line.get_label() for line in speed] == names
    power = axes["auxiliary load,\nPower [W]"]
    (course,), (band,) = power.get_lines(), power.collections
    assert set(course.get_ydata()) == {2.0, 9.0}
    ends = band.get_paths()[0].vertices[:, 1]
    assert (ends.min(), ends.max()) == (1.0, 10.0)
    legend = next(iter(axes.values())).get_legend()
    assert [text.get_text() for text in legend.get_texts()] == names


def test_the_mended_vehicle_misses_what_its_prices_leave():
    """By its motion, whatever the torque that was logged says."""
    car = load_vehicle("r1t_epa")
    cycle = parse_cycle("hwfet[0:60]")
    run = simulate(car, cycle, imposed=True, output_rate=10.0).trace
    seen = ("time_s", "speed_mps", "battery_power_w")
    log = {c: run[c] for c in seen} | {"motor_torque_nm": run["motor_torque_nm"] + 30}
    plain = problem_of(Trace(log, name="log"), car)
    lighter = {"body.mass_kg": 0.9 * car.figure("body.mass_kg").value}
    found = SimpleNamespace(
        plain=plain, fit=SimpleNamespace(values=lighter), asserted=[], shown=0
    )
    missed = log["battery_power_w"] - mended(found)["battery_power_w"]
    left = prices(plain, [], lighter).unexplained_wh
    assert np.trapezoid(missed, log["time_s"]) / 3600 == pytest.approx(left, rel=1e-3)
    assert left > 10.0


@pytest.mark.parametrize("words", [1, 12, 20])
def test_a_line_above_a_sheet_stays_within_it(words):
    figure, _ = sheet(3, height=1.0)
    head(figure, " or ".join(["rolling_resistance"] * words), "+0.1 Wh")
    figure.draw_without_rendering()
    assert figure.get_suptitle().endswith("\n+0.1 Wh")
    drawn = figure._suptitle.get_window_extent()
    assert 0 < drawn.x0 < drawn.x1 < figure.bbox.x1
    assert drawn.y1 < figure.bbox.y1
