"""The main job on built-in input: scale, drive twice, diagnose a withheld effect."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcc_sim.analyse.energy import compared, energy_report
from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import open_log
from rcc_sim.blind.make import make
from rcc_sim.blind.own import base_of
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.deliver import write_mended
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.diagnose.run import diagnose
from rcc_sim.errors import InputError
from rcc_sim.report.diagnosis_page import diagnosis_page
from rcc_sim.report.energy_page import energy_page
from rcc_sim.report.html import write_html
from rcc_sim.report.plots import plot_energy, plot_run, save
from rcc_sim.report.screen import screen
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace, write_trace
from rcc_sim.units import unit_of

LANE_CHANGE_EVERY = 20.0  # m; as on the paper's track

SEED = 8
"""Of the drive whose cause is withheld: one that is easy to picture."""

Row = dict[str, Any]
Say = Callable[[str], None]


@dataclass(frozen=True)
class Demo:
    """What the demo found and wrote; the last row holds the report's path."""

    title: str
    rows: list[Row]
    files: list[Path]


def run_demo(folder: Path, say: Say) -> Demo:
    """Drive UDDS at the RC car's scale; then diagnose a drive whose cause is sealed.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror}") from None
    try:
        rows, files = _driven(folder, say)
        more, others = _diagnosed(folder, say)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror}") from None
    report = files + others
    rows = [*rows, *more, _row("report", str(report[-1]), "")]
    return Demo("What the demo found", rows, report)


def _driven(folder: Path, say: Say) -> tuple[list[Row], list[Path]]:
    """Drive straight and changing lanes; report the energy."""
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
    more = compared(reports)[0]["wh_per_km_percent"]
    rows = [
        _row("UDDS at the car's scale", reports[0].wh_per_km, "Wh/km"),
        _row("lane changes every 20 m add", more, "%"),
    ]
    return rows, files


def _diagnosed(folder: Path, say: Say) -> tuple[list[Row], list[Path]]:
    """Diagnose a drive of the plant, which is not the model; then open its label."""
    say(
        f"rccsim blind make secret --vehicle rcc --cases 1 --kinds single --seed {SEED}"
    )
    case, truth = _sealed(folder)
    log, file = case / "log.csv.gz", case / "vehicle.toml"
    say(
        f"rccsim diagnose {log.relative_to(folder)} --vehicle "
        f"{file.relative_to(folder)} --write-vehicle mended.toml --html diagnosis.html"
    )
    car = load_vehicle(file)
    found = diagnose([open_log(str(log), car)], car)
    for line in screen(found):
        say(f"  {line}")
    mended = folder / "mended.toml"
    write_mended(found, mended)
    say("rccsim gap secret/c0000/fresh.csv.gz --vehicle mended.toml")
    fresh = [
        gap(open_log(str(case / "fresh.csv.gz"), v), v).energy.gap_percent
        for v in (car, load_vehicle(mended))
    ]
    page = folder / "diagnosis.html"
    with open(page, "w", encoding="utf-8") as out:
        write_html(diagnosis_page(found, [log, file]), out)
    return _told(found, truth, fresh), [log, file, mended, page]


def _sealed(folder: Path) -> tuple[Path, Mapping[str, Any]]:
    """Make one case in place of an earlier demo's; return its folder and its label."""
    with tempfile.TemporaryDirectory() as place:
        seal = make(
            Path(place) / "secret",
            cases=1,
            seed=SEED,
            kinds=("single",),
            base=base_of("rcc"),
        )
        truth = json.loads(seal.labels.read_text("utf-8"))["cases"]["c0000"]
        shutil.copytree(Path(place) / "secret", folder / "secret", dirs_exist_ok=True)
        shutil.copy(seal.labels, folder)
    return folder / "secret" / "c0000", truth


def _told(
    found: Diagnosis, truth: Mapping[str, Any], fresh: list[float | None]
) -> list[Row]:
    """Return what was found beside what was sealed."""
    rows = [
        _row(
            "of the energy that a log took, its model misses",
            found.gap.energy.gap_percent,
            "%",
        ),
    ]
    for a in found.asserted:
        rows.append(_row("cause found", a.cause.effect, ""))
        for name, e in a.figures.items():
            told = f"{e.value:.4g} ({e.low:.4g} to {e.high:.4g})"
            rows.append(_row(f"{a.cause.effect} found", told, unit_of(name)))
    for effect, figures in truth["magnitudes"].items():
        for name, x in figures.items():
            rows.append(_row(f"{effect} sealed, opened now", x, unit_of(name)))
    before, after = fresh
    rows.append(_row("another drive, gap before", before, "%"))
    rows.append(_row("another drive, gap with the mended vehicle", after, "%"))
    return rows


def _row(what: str, value: Any, unit: str) -> Row:
    return {"what": what, "value": value, "unit": "" if unit == "1" else unit}
