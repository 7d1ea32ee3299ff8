"""`rccsim diagnose`: which unmodelled effect parts a log from the model."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.batches import Dask, Jobs
from rcc_sim.cli.complete import effect_names, own_effects
from rcc_sim.cli.fleets import (
    Asked,
    By,
    CarColumn,
    Each,
    List,
    one_log,
    refuse_single,
    run_fleet,
)
from rcc_sim.cli.logs import (
    Hide,
    Map,
    Model,
    Plot,
    Reader,
    Repeats,
    Span,
    notes_of,
    once,
    span_of,
    tell_notes,
    write_page,
)
from rcc_sim.cli.output import (
    Csv,
    Json,
    Output,
    Text,
    emit,
    emit_text,
    not_foreign,
    one_format,
    say,
)
from rcc_sim.cli.overrides import vehicle_of
from rcc_sim.errors import InputError, did_you_mean
from rcc_sim.files import atomic

if TYPE_CHECKING:
    from rcc_sim.diagnose.diagnosis import Diagnosis

EXAMPLE = (
    "Example: rccsim simulate rcc --cycle 'udds[20:125]' "
    "--with rolling_resistance:coefficient=0.02 -o drive.csv; "
    "rccsim diagnose drive.csv --vehicle rcc"
)


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command("diagnose", epilog=EXAMPLE)(diagnose)


def diagnose(
    vehicle: Model,
    logs: Annotated[
        list[str] | None,
        typer.Argument(
            help="Logs of one vehicle, all explained at once; with --each, or as a "
            "folder or a pattern, a fleet: each on its own."
        ),
    ] = None,
    withhold: Annotated[
        list[str] | None,
        typer.Option(
            help="Take a known effect out of the vehicle; repeatable.",
            metavar="EFFECT",
            autocompletion=own_effects,
        ),
    ] = None,
    hide: Hide = None,
    span: Span = None,
    candidates: Annotated[
        list[str] | None,
        typer.Option(
            help="Consider this effect; repeatable, or a,b. All where not given, but "
            "for steering_drag, which few cars have.",
            metavar="EFFECT",
            autocompletion=effect_names,
        ),
    ] = None,
    holdout: Annotated[
        list[str] | None,
        typer.Option(help="A log that is only judged; repeatable.", metavar="LOG"),
    ] = None,
    back: Annotated[
        list[str] | None,
        typer.Option(
            help="A log driven the other way along the road of the others, in which "
            "slope and wind come from the other side; repeatable.",
            metavar="LOG",
        ),
    ] = None,
    on_stand: Annotated[
        list[str] | None,
        typer.Option(
            help="A log of the same vehicle whose wheels turn off the ground: no road "
            "acts in it; repeatable.",
            metavar="LOG",
        ),
    ] = None,
    repeats: Repeats = None,
    reader: Reader = None,
    map_: Map = None,
    write_vehicle: Annotated[
        Path | None,
        typer.Option(help="Write the mended vehicle.", metavar="F.toml"),
    ] = None,
    profiles: Annotated[
        Path | None,
        typer.Option(
            help="Write the causes that vary, over time; a file each log.",
            metavar="F.csv",
            callback=not_foreign,
        ),
    ] = None,
    next_run: Annotated[
        Path | None,
        typer.Option(
            help="Write a run to drive next: .csv, or .mcap for ROS 2.",
            metavar="F",
            callback=not_foreign,
        ),
    ] = None,
    plot: Plot = None,
    html: Annotated[
        Path | None, typer.Option(help="Write it as a page.", metavar="F.html")
    ] = None,
    each: Each = False,
    list_: List = None,
    by: By = None,
    car: CarColumn = None,
    jobs: Jobs = 1,
    dask: Dask = None,
    output: Output = None,
    text: Text = False,
    csv: Csv = False,
    json: Json = False,
) -> None:
    """Which unmodelled effect parts a log from the model, how much, and how sure.

    Null, every effect, sets of them and something unknown compete; the vehicle
    file's sds are tolerances. Causes are proven on stretches that no fit saw.
    """
    effects = [name for one in candidates or () for name in one.split(",")]
    asked = Asked(
        tuple(logs or ()), each, list_, tuple(by or ()), car or "", jobs, dask or "",
        html, output, csv, json,
    )  # fmt: skip
    if asked.is_fleet:
        refuse_single(
            {
                "--repeats": repeats,
                "--span": span,
                "--back": back,
                "--on-stand": on_stand,
                "--holdout": holdout,
                "--write-vehicle": write_vehicle,
                "--profiles": profiles,
                "--next-run": next_run,
                "--plot": plot,
                "--text": text,
            }
        )
        options = {"vehicle": vehicle, "withhold": withhold, "hide": hide}
        options |= {"candidates": effects, "reader": reader, "map": map_}
        _fleet(asked, options)
        return
    one_log(asked)
    hint = "what --html writes is for people, too" if text else ""
    one_format(json=json, csv=csv, text=text, hint=hint)
    logs, back, on_stand = logs or [], back or [], on_stand or []
    inputs = [*logs, *back, *on_stand, *(holdout or []), *(repeats or [])]
    once(inputs)
    if plot is not None:
        from rcc_sim.report.plots import format_of

        format_of(plot)  # before a fit that takes its time
    found = _found(
        logs, back, on_stand, vehicle, withhold or [], hide or [], effects,
        holdout or [], repeats or [], span_of(span), reader, map_, next_run,
    )  # fmt: skip
    _write(found, write_vehicle, profiles, next_run)
    if plot is not None or html is not None:
        _draw(found, [*inputs, vehicle], plot, html)
    _deliver(found, output, text=text, csv=csv, json=json)


def _draw(
    found: Diagnosis, read: list[str], plot: Path | None, html: Path | None
) -> None:
    from rcc_sim.report.diagnosis_page import diagnosis_page

    page = diagnosis_page(found, read)
    if plot is not None:
        from rcc_sim.report.diagnosis_plot import plot_diagnosis
        from rcc_sim.report.plots import save

        save(plot_diagnosis(found, page), plot)
        say(f"wrote {plot}")
    if html is not None:
        write_page(page, html)


def _fleet(asked: Asked, options: dict[str, Any]) -> None:
    from rcc_sim.batch.fleet_rows import DIAGNOSE, diagnose_row

    run_fleet(asked, "diagnose", diagnose_row, DIAGNOSE, options)


def _found(
    logs: list[str],
    back: list[str],
    on_stand: list[str],
    vehicle: str,
    withhold: list[str],
    hide: list[str],
    candidates: list[str],
    holdout: list[str],
    repeats: list[str],
    span: tuple[float, float],
    reader: str | None,
    map_: str | None,
    next_run: Path | None,
) -> Diagnosis:
    import gc
    import os

    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the logs keep the cores busy
    from rcc_sim.analyse.logged import open_log
    from rcc_sim.cli.progress import told
    from rcc_sim.diagnose.deliver import refuse_bag
    from rcc_sim.diagnose.residuals.posed import problem_of
    from rcc_sim.diagnose.run import diagnose

    gc.freeze()  # what was imported stays: no need to look through it again and again
    car = vehicle_of(vehicle)
    for name in withhold:
        if name not in car.effects:
            what = f"--withhold {name}: {car.name} does not have it"
            raise InputError(what, did_you_mean(name, car.effects))
    car = car.changed(without=tuple(withhold)) if withhold else car

    def opened(names: list[str], **where: Any) -> list[Any]:
        return [
            open_log(name, car, reader=reader, columns=map_, hide=hide, **where)
            for name in names
        ]

    found = [
        *opened(logs, span=span),
        *opened(back, span=span, back=True),
        *opened(on_stand, span=span, on_stand=True),
    ]
    if next_run is not None:
        refuse_bag(next_run, lambda: problem_of(found[0].log, car))
    # before a fit that takes its time: it may be the wrong vehicle, or unit
    tell_notes([(one.log.name, notes_of(one.findings)) for one in found])
    with told("diagnosing") as tell:
        return diagnose(
            found,
            car,
            candidates=candidates,
            holdouts=opened(holdout),
            repeats=[one.log for one in opened(repeats, span=span)],
            withheld=withhold,
            told=tell,
        )


def _write(
    found: Diagnosis,
    vehicle: Path | None,
    profiles: Path | None,
    next_run: Path | None,
) -> None:
    from rcc_sim.diagnose.deliver import (
        varying,
        write_mended,
        write_next_run,
        write_profiles,
    )

    if vehicle is not None:
        write_mended(found, vehicle)
        say(f"wrote {vehicle}")
        for note in _of_mended(found, vehicle):
            say(f"note: {note}")
    if profiles is not None:
        for i in range(len(found.gaps)):
            path = profiles.with_suffix(f".{i + 1}{profiles.suffix}") if i else profiles
            with atomic(path, "wb") as file:
                write_profiles(found, file, i)
            say(f"wrote {path}")
        if not varying(found):
            say(f"note: no cause varies over the drive; {profiles} holds time_s alone")
    if next_run is not None:
        run = write_next_run(found, next_run)
        proposed = [e.run for e in found.experiments]
        if any(run is one for one in proposed):
            by_hand = run is not proposed[0]
            why = "; what NEXT has first is driven by hand" if by_hand else ""
        elif proposed:
            why = (
                "; what NEXT has is driven by hand, and this need not part what is tied"
            )
        elif found.is_tied:
            why = "; no run of the menu parts what is tied"
        else:
            why = "; nothing is tied or wide"
        say(f"wrote {next_run}: {run.do}{why}")
        if run.is_both_ways:
            often = f", {run.times} times" if run.times > 1 else ""
            say(
                f"note: {next_run} is one way: drive it out and back{often}, and name "
                "the logs of the way back with --back"
            )


def _of_mended(found: Diagnosis, vehicle: Path) -> Iterator[str]:
    """Yield what to know of a mended vehicle file."""
    from rcc_sim.diagnose.deliver import over_time, varying
    from rcc_sim.diagnose.judge.energies import grew

    for a in (a for a in found.asserted if a.cause.tied):
        tied = ", ".join(a.cause.tied)
        yield f"{vehicle} has {a.cause.effect}; it might as well be {tied}"
    if not found.asserted:
        told = f"{len(found.figures())} stated figures as these logs have them"
        real = found.status == "unexplained"
        told += "; they may stand in for what nothing explains" * real
        yield f"no cause; {vehicle} holds {told}"
    if "wheel_radius" in found.effects().keys() - {
        a.cause.effect for a in found.asserted
    }:
        yield "wheel_radius.scale holds what these logs make of tyres.radius_m"
    for key, sds in found.elsewhere.items():
        yield f"{key} is {sds:.0f} sds off what was stated; {vehicle} holds it"
    for column in found.hidden:
        yield f"{vehicle} holds what {column} was hidden for: hide it again"
    for effect in over_time(found):
        over = found.gap.log if len(found.gaps) == 1 else "all logs"
        yield f"{effect} varies; {vehicle} holds its mean over {over}"
    for effect in dict.fromkeys(varying(found)):
        if effect not in over_time(found):
            yield (
                f"{effect} lies along the road that was driven: on another road, take "
                f"it out of {vehicle}"
            )
    before, after = found.proof.before, found.proof.after
    if before is not None and after is not None and grew(before, after):
        yield (
            f"the energy gap grows with {vehicle}, on rows that no fit saw from "
            f"{before:+.3g} to {after:+.3g} %: what is missing is not in it"
        )


def _deliver(
    found: Diagnosis, output: Path | None, *, text: bool, csv: bool, json: bool
) -> None:
    from shutil import get_terminal_size

    from rcc_sim.analyse.gap import not_logged
    from rcc_sim.report.screen import screen
    from rcc_sim.report.verdict import verdict_of

    gaps = found.gaps
    told = [
        notes_of(
            (f for f in g.findings if f.kind == "misread"),
            not_logged(g.measured, g.energy),
        )
        for g in gaps
    ]
    tell_notes([(g.log, mine) for g, mine in zip(gaps, told, strict=True)])
    if text or (output is None and sys.stdout.isatty() and not (json or csv)):
        emit_text(screen(found, get_terminal_size().columns), output=output)
        return
    document = found.document()
    say(verdict_of(document))
    rows = [
        {k: v for k, v in row.items() if not isinstance(v, dict | list)}
        for row in document["ranking"]
    ]
    emit(document, rows, json=json, csv=csv, output=output)
