"""The main job on built-in input: scale, drive twice, report."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcc_sim.analyse.energy import energy_report, table
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.report.energy_page import energy_page
from rcc_sim.report.html import write_html
from rcc_sim.report.plots import plot_energy, plot_run, save
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace, write_trace

LANE_CHANGE_EVERY = 20.0  # m; as on the paper's track


@dataclass(frozen=True)
class Demo:
    """What the demo made."""

    title: str
    rows: list[dict[str, Any]]
    files: list[Path]


def run_demo(folder: Path, say: Callable[[str], None]) -> Demo:
    """Drive UDDS at the RC car's scale, straight and changing lanes.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror}") from None
    car, truck = load_vehicle("rcc"), load_vehicle("r1t")
    say("rccsim scale-cycle udds --from r1t --to rcc -o scaled.csv")
    scaled = scale_cycle(parse_cycle("udds"), to=car, of=truck).cycle
    say("rccsim simulate rcc --cycle scaled.csv -o straight.csv")
    straight = simulate(car, scaled).trace
    say("rccsim simulate rcc --cycle scaled.csv --lane-change-every 20 -o lanes.csv")
    lanes = simulate(car, scaled, lanes=LaneChanges(LANE_CHANGE_EVERY)).trace
    say("rccsim energy straight.csv lanes.csv --plot energy.png --html energy.html")
    straight = Trace(straight.columns, name="straight")
    lanes = Trace(lanes.columns, name="lane changes")
    cycle = Trace({"time_s": scaled.time_s, "speed_mps": scaled.speed_mps})
    files = []
    for name, trace in (("scaled", cycle), ("straight", straight), ("lanes", lanes)):
        files.append(folder / f"{name}.csv")
        with open(files[-1], "wb") as file:
            write_trace(trace, file)
    reports = [energy_report(straight), energy_report(lanes)]
    for name, figure in (
        ("run.png", plot_run(straight, lanes)),
        ("energy.png", plot_energy([straight, lanes], reports)),
    ):
        files.append(folder / name)
        save(figure, files[-1])
    files.append(folder / "energy.html")
    inputs = [folder / "straight.csv", folder / "lanes.csv"]
    with open(files[-1], "w", encoding="utf-8") as page:
        write_html(energy_page([straight, lanes], reports, inputs), page)
    return Demo("UDDS at the RC car's scale, by energy", table(reports), files)
