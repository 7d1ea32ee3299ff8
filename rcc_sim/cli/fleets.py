"""Commands over many logs: how they are asked for, run, and told."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.batches import ProgressLine, going_on, tell_failures
from rcc_sim.cli.keep import keep
from rcc_sim.cli.output import emit, say
from rcc_sim.files import atomic

if TYPE_CHECKING:
    from rcc_sim.batch.fleet import Fleet, RowOf
    from rcc_sim.batch.fleet_logs import Entry
    from rcc_sim.batch.store import Manifest

Each = Annotated[
    bool,
    typer.Option(
        "--each",
        help="A fleet: each log on its own, a row a log, and what they have in common. "
        "A folder, a pattern or --list asks for it too.",
    ),
]
List = Annotated[
    str | None,
    typer.Option(
        "--list",
        help="Logs of a fleet: a path a line, or CSV with a column log, perhaps "
        "vehicle, and labels such as car, date; - for stdin.",
        metavar="F",
    ),
]
By = Annotated[
    list[str] | None,
    typer.Option(
        help="Gather a fleet by this column; repeatable. Default: vehicle, "
        "temperature, date.",
        metavar="COLUMN",
    ),
]
CarColumn = Annotated[
    str | None,
    typer.Option(
        "--car",
        help="Column that names the car: its stated figures are off by the same in "
        "all its logs. Default: the model is one car.",
        metavar="COLUMN",
    ),
]


@dataclass(frozen=True)
class Asked:
    """What the options of a fleet say.

    Parameters
    ----------
    names : tuple of str
        Logs, folders, patterns.
    each : bool
        Whether a fleet was asked for in so many words.
    lists : str or None
        List of logs.
    by : tuple of str
        Columns by which the summary gathers.
    car : str
        Column that names the car.
    jobs, dask
        Where to work.
    html, output
        Files to write.
    csv, json : bool
        What to print.
    """

    names: tuple[str, ...]
    each: bool = False
    lists: str | None = None
    by: tuple[str, ...] = ()
    car: str = ""
    jobs: int = 1
    dask: str = ""
    html: Path | None = None
    output: Path | None = None
    csv: bool = False
    json: bool = False

    @property
    def is_fleet(self) -> bool:
        """Whether the logs are a fleet, and not one log or one explanation."""
        from rcc_sim.batch.fleet_logs import is_many

        return self.each or self.lists is not None or any(map(is_many, self.names))


def one_log(asked: Asked) -> str:
    """Return the first log where no fleet was asked for.

    Raises
    ------
    InputError
        If there is none, or options of a fleet were given.
    """
    from rcc_sim.errors import InputError

    if not asked.names:
        raise InputError("no log", "name one, or a folder, or give a --list")
    if asked.by or asked.car or asked.jobs > 1 or asked.dask:
        raise InputError(
            "--by, --car, --jobs and --dask: belong to a fleet", "add --each"
        )
    if asked.output is not None and asked.output.is_dir():
        raise InputError(f"--output: {asked.output}: is a folder", "name a file in it")
    return asked.names[0]


def refuse_single(options: Mapping[str, object]) -> None:
    """Raise for an option that belongs to a single log.

    Raises
    ------
    InputError
        Naming the first that was given.
    """
    from rcc_sim.errors import InputError

    for name, value in options.items():
        if value:
            raise InputError(
                f"{name}: belongs to a single log, not to a fleet",
                "give the log that is worth it by itself",
            )


def run_fleet(
    asked: Asked,
    command: str,
    row: RowOf,
    columns: Mapping[str, str],
    options: Mapping[str, Any],
) -> dict[str, Any]:
    """Do a command on every log, keep the rows, tell what they come to; return that.

    Raises
    ------
    InputError
        If there are no logs, no such model, column, effect, scheduler; or, once the
        rows are told, if not one of the logs could be used.
    """
    from rcc_sim.batch.engine import Engine
    from rcc_sim.processes import ONE_THREAD

    os.environ |= ONE_THREAD  # before numpy comes: a log's bytes hang on it
    from rcc_sim.batch.batch import run_batch
    from rcc_sim.batch.fleet import rows_in
    from rcc_sim.batch.fleet_summary import summary
    from rcc_sim.errors import InputError

    fleet = _fleet(asked, command, row, columns, options)
    written = {"--output": asked.output, "--html": asked.html}
    keep((log.log for log in fleet.logs), written, folders=["--output"])
    with _place(asked.output) as place:
        line = ProgressLine("logs")
        with going_on(asked.output):
            progress = run_batch(fleet, place, Engine(asked.jobs, asked.dask), line)
        line.end()
        rows = rows_in(place, fleet.manifest)
        found = summary(rows, command, by=asked.by, car=asked.car)
        found |= {"output": asked.output and str(asked.output)}
        tell_failures(progress, "logs")
        _deliver(asked, found, place, fleet.manifest)
    if asked.output is not None:
        new = progress.total - progress.before
        say(f"wrote {asked.output}: {progress.total:,} logs ({new:,} now)")
    if found["failed"] == found["logs"]:
        raise InputError(
            f"none of the {found['logs']:,} logs could be used",
            "the rows say why; rccsim check LOG tells it of one",
        )
    return found


def _fleet(
    asked: Asked,
    command: str,
    row: RowOf,
    columns: Mapping[str, str],
    options: Mapping[str, Any],
) -> Fleet:
    from dataclasses import replace

    from rcc_sim.batch.fleet import Fleet
    from rcc_sim.batch.fleet_logs import entries_of

    with _listed(asked.lists) as lists:
        logs = entries_of(asked.names, lists)
    models = {name: _portable(name) for name in _models(logs, options)}
    _check_effects(list(models), options)
    logs = tuple(replace(e, vehicle=models.get(e.vehicle, "")) for e in logs)
    given = {**options, "vehicle": models.get(options.get("vehicle") or "")}
    if options.get("map"):
        from rcc_sim.readers import load_map

        load_map(options["map"])
        path = Path(options["map"])
        given["map"] = str(path.resolve()) if path.is_file() else options["map"]
    if options.get("reader"):
        from rcc_sim.readers import named

        named(options["reader"])
    fleet = Fleet(command, row, logs, columns, given, tuple(models.values()))
    _check_columns(asked, fleet)
    return fleet


def _models(logs: Sequence[Entry], options: Mapping[str, Any]) -> list[str]:
    own = [options["vehicle"]] if options.get("vehicle") else []
    return list(dict.fromkeys([*own, *(e.vehicle for e in logs if e.vehicle)]))


def _portable(name: str) -> str:
    """Return what finds a model from any folder: a file's whole path, or its name."""
    from rcc_sim.definitions.vehicle import load_vehicle

    car = load_vehicle(name)
    if car.path is None or car.origin == "shipped" or car.origin.startswith("plugin"):
        return name
    return str(car.path.resolve())


def _check_effects(models: Sequence[str], options: Mapping[str, Any]) -> None:
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.errors import InputError
    from rcc_sim.physics.effect import meant

    for name in models:
        car = load_vehicle(name)
        car.changed(without=tuple(options.get("withhold") or ()))
        for effect in options.get("candidates") or ():
            if effect not in car.known:
                what = f"--candidates: {effect}: no such effect"
                raise InputError(what, meant(effect, car.known))


def _check_columns(asked: Asked, fleet: Fleet) -> None:
    from rcc_sim.batch.fleet import PLACE
    from rcc_sim.batch.fleet_rows import TEMPERATURE
    from rcc_sim.errors import InputError

    for name in set(fleet.labels) & {*PLACE, *fleet.columns, "error"}:
        if name not in ("date", TEMPERATURE):
            raise InputError(f"--list: {name}: is what a row says of the log itself")
    if fleet.labels.get(TEMPERATURE) == "string":
        raise InputError(f"--list: {TEMPERATURE}: should be numbers")
    known = [*PLACE, *fleet.labels, *fleet.columns]
    for name in (*asked.by, *([asked.car] if asked.car else [])):
        if name not in known:
            raise InputError(
                f"{name}: no such column of a row", f"there are {', '.join(known)}"
            )


@contextlib.contextmanager
def _listed(name: str | None) -> Iterator[Any]:
    from rcc_sim.errors import InputError

    if name is None:
        yield None
    elif name == "-":
        yield sys.stdin
    else:
        try:
            file = open(name, encoding="utf-8-sig")  # noqa: SIM115
        except OSError as error:
            raise InputError(f"{name}: cannot be read: {error.strerror}") from None
        with file:
            yield file


@contextlib.contextmanager
def _place(output: Path | None) -> Iterator[Path]:
    """Give the place of the rows: a dataset, kept where one was named."""
    if output is None:
        with tempfile.TemporaryDirectory() as folder:
            yield Path(folder, "rows")
    elif output.suffix == ".csv":
        yield output.with_name(f"{output.name}.parts")
    else:
        yield output


def _deliver(
    asked: Asked, found: dict[str, Any], place: Path, manifest: Manifest
) -> None:
    from rcc_sim.batch.fleet import rows_in
    from rcc_sim.batch.fleet_table import write_csv
    from rcc_sim.report.fleet_tables import lines, tables

    if asked.output is not None and asked.output.suffix == ".csv":
        with atomic(asked.output) as file:
            write_csv(rows_in(place, manifest), file)
    if asked.html is not None:
        from rcc_sim.report.fleet_page import fleet_page

        page = fleet_page(found, rows_in(place, manifest))
        with atomic(asked.html) as file:
            file.write(page)
        say(f"wrote {asked.html}")
    for line in lines(found):
        say(line)
    if asked.json:
        emit(found, [], json=True)
    elif asked.csv or (asked.output is None and not sys.stdout.isatty()):
        write_csv(rows_in(place, manifest), sys.stdout)
    elif sys.stdout.isatty():
        for title, rows in tables(found):
            emit(None, rows, title=title)
