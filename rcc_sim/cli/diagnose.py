"""`rccsim diagnose`: which unmodelled effect parts a log from the model."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.complete import (
    column_names,
    effect_names,
    map_names,
    own_effects,
    vehicle_names,
)
from rcc_sim.cli.output import Csv, Json, Output, atomic, emit, say

if TYPE_CHECKING:
    from rcc_sim.diagnose.run import Diagnosis

EXAMPLE = (
    "Example: rccsim simulate rcc --cycle 'udds[20:125]' --lane-change-every 20 "
    "--with rolling_resistance:coefficient=0.02 -o drive.csv; "
    "rccsim diagnose drive.csv --vehicle rcc"
)


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command("diagnose", epilog=EXAMPLE)(diagnose)


def diagnose(
    logs: Annotated[
        list[str], typer.Argument(help="Logs of one vehicle, all explained at once.")
    ],
    vehicle: Annotated[
        str,
        typer.Option(help="The model: a name or file.", autocompletion=vehicle_names),
    ],
    withhold: Annotated[
        list[str] | None,
        typer.Option(
            help="Take a known effect out of the vehicle; repeatable.",
            metavar="EFFECT",
            autocompletion=own_effects,
        ),
    ] = None,
    hide: Annotated[
        list[str] | None,
        typer.Option(
            help="Leave a logged column out; repeatable.",
            metavar="COLUMN",
            autocompletion=column_names,
        ),
    ] = None,
    candidates: Annotated[
        list[str] | None,
        typer.Option(
            help="Consider this effect; repeatable. All where not given.",
            metavar="EFFECT",
            autocompletion=effect_names,
        ),
    ] = None,
    holdout: Annotated[
        list[str] | None,
        typer.Option(help="A log that is only judged; repeatable.", metavar="LOG"),
    ] = None,
    repeats: Annotated[
        list[str] | None,
        typer.Option(
            help="Another log of the same drive, to know the noise by; repeatable.",
            metavar="LOG",
        ),
    ] = None,
    reader: Annotated[
        str | None, typer.Option(help="Force a reader; the file tells otherwise.")
    ] = None,
    map_: Annotated[
        str | None,
        typer.Option(
            "--map",
            help="Column map: a TOML file or a shipped name.",
            autocompletion=map_names,
        ),
    ] = None,
    write_vehicle: Annotated[
        Path | None,
        typer.Option(help="Write the mended vehicle.", metavar="F.toml"),
    ] = None,
    profiles: Annotated[
        Path | None,
        typer.Option(help="Write the causes that vary, over time.", metavar="F.csv"),
    ] = None,
    next_run: Annotated[
        Path | None,
        typer.Option(
            help="Write a run to drive next: .csv, or .mcap for ROS 2.",
            metavar="F",
        ),
    ] = None,
    html: Annotated[
        Path | None, typer.Option(help="Write it as a page.", metavar="F.html")
    ] = None,
    output: Output = None,
    csv: Csv = False,
    json: Json = False,
) -> None:
    """Which unmodelled effect parts a log from the model, how much, and how sure.

    Null, every effect, sets of them and something unknown compete; the vehicle
    file's sds are tolerances. Causes are proven on stretches that no fit saw.
    """
    found = _found(
        logs, vehicle, withhold or [], hide or [], candidates or [], holdout or [],
        repeats or [], reader, map_,
    )  # fmt: skip
    _write(found, write_vehicle, profiles, next_run)
    if html is not None:
        _page(found, html, [*logs, vehicle])
    _deliver(found, output, csv=csv, json=json)


def _found(
    logs: list[str],
    vehicle: str,
    withhold: list[str],
    hide: list[str],
    candidates: list[str],
    holdout: list[str],
    repeats: list[str],
    reader: str | None,
    map_: str | None,
) -> Diagnosis:
    import os

    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the logs keep the cores busy
    from rcc_sim.analyse.logged import open_log
    from rcc_sim.cli.progress import told
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.diagnose.run import diagnose

    car = load_vehicle(vehicle)
    if withhold:
        car = car.changed(without=tuple(withhold))

    def opened(names: list[str]) -> list[Any]:
        return [
            open_log(name, car, reader=reader, columns=map_, hide=hide)
            for name in names
        ]

    with told("diagnosing") as tell:
        return diagnose(
            opened(logs),
            car,
            candidates=candidates,
            holdouts=opened(holdout),
            repeats=[one.log for one in opened(repeats)],
            told=tell,
        )


def _page(found: Diagnosis, path: Path, inputs: list[str]) -> None:
    from rcc_sim.report.diagnosis_page import diagnosis_page
    from rcc_sim.report.html import write_html

    page = diagnosis_page(found, inputs)
    with atomic(path) as file:
        write_html(page, file)
    say(f"wrote {path}")


def _write(
    found: Diagnosis,
    vehicle: Path | None,
    profiles: Path | None,
    next_run: Path | None,
) -> None:
    from rcc_sim.diagnose.deliver import write_mended, write_next_run, write_profiles

    if vehicle is not None:
        write_mended(found, vehicle)
        say(f"wrote {vehicle}")
    if profiles is not None:
        with atomic(profiles, "wb") as file:
            write_profiles(found, file)
        say(f"wrote {profiles}")
    if next_run is not None:
        write_next_run(found, next_run)
        say(f"wrote {next_run}")


def _deliver(found: Diagnosis, output: Path | None, *, csv: bool, json: bool) -> None:
    from shutil import get_terminal_size

    from rcc_sim.report.screen import screen

    for finding in found.document()["findings"]:
        if finding["severity"] != "info":
            say(f"note: {finding['channel']} {finding['what']}; {finding['action']}")
    if output is None and sys.stdout.isatty() and not (json or csv):
        for line in screen(found, get_terminal_size().columns):
            typer.echo(line)
        return
    rows = [
        {k: v for k, v in row.items() if not isinstance(v, dict | list)}
        for row in found.document()["ranking"]
    ]
    emit(found.document(), rows, json=json, csv=csv, output=output)
