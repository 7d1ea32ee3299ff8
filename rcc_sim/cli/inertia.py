"""`rccsim inertia`: yaw inertia from a bifilar pendulum."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.output import Csv, Json, Output, emit, warn

if TYPE_CHECKING:
    from rcc_sim.identify.bifilar import YawInertia


EXAMPLE = (
    "Example: rccsim inertia --mass 3.78 --spacing 0.535 --length 0.60 --period 0.589"
)


def inertia(
    mass: Annotated[float, typer.Option(help="Everything on the wires. [kg]")],
    spacing: Annotated[float, typer.Option(help="Between the wires. [m]")],
    length: Annotated[float, typer.Option(help="Of the wires. [m]")],
    period: Annotated[
        list[float] | None, typer.Option(help="Full period; repeatable. [s]")
    ] = None,
    log: Annotated[
        str | None,
        typer.Option(help="Gyro log with time_s, yaw_rate_radps: finds the period."),
    ] = None,
    cycles: Annotated[
        int, typer.Option(help="Swings that each given period was timed over.", min=1)
    ] = 1,
    amplitude: Annotated[
        float | None, typer.Option(help="Of the swing, to correct for it. [rad]")
    ] = None,
    mass_sd: Annotated[float, typer.Option(help="[kg]")] = 0.0,
    spacing_sd: Annotated[float, typer.Option(help="[m]")] = 0.0,
    length_sd: Annotated[float, typer.Option(help="[m]")] = 0.0,
    period_sd: Annotated[float, typer.Option(help="[s]")] = 0.0,
    tare_mass: Annotated[
        float | None, typer.Option(help="Of the bare carrier. [kg]")
    ] = None,
    tare_period: Annotated[
        float | None, typer.Option(help="Of the bare carrier. [s]")
    ] = None,
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """Yaw inertia from the period of a bifilar pendulum, with its uncertainty."""
    from rcc_sim.identify.bifilar import yaw_inertia

    hung = (mass, spacing, length)
    T, T_sd = _periods(period, period_sd, log, hung)
    if log is not None and amplitude is not None:
        warn("--amplitude: not needed, the log tells that of each swing")
        amplitude = None
    result = yaw_inertia(
        mass,
        T,
        spacing,
        length,
        m_sd=mass_sd,
        T_sd=T_sd,
        d_sd=spacing_sd,
        h_sd=length_sd,
        cycles=cycles,
        amplitude=amplitude,
        tare_mass=tare_mass,
        tare_period=tare_period,
    )
    for text in result.warnings:
        warn(text)
    row = _document(result)
    emit(row | {"variance_share": dict(result.budget)}, [row], json=json, csv=csv,
         output=output)  # fmt: skip


def _periods(
    period: list[float] | None,
    period_sd: float,
    log: str | None,
    hung: tuple[float, float, float],
) -> tuple[Any, Any]:
    from rcc_sim.errors import InputError
    from rcc_sim.identify.bifilar import lengthening, oscillation_period

    if (log is None) == (not period):
        raise InputError(
            "inertia: give --period (repeatable) or --log, one of them",
            "a gyro log has the columns time_s and yaw_rate_radps",
        )
    if log is None:
        return period, period_sd
    from rcc_sim.trace import read_trace

    trace = read_trace(log)
    swings = trace["time_s"], trace["yaw_rate_radps"]
    mass, spacing, length = hung
    about = oscillation_period(*swings).T
    found = oscillation_period(*swings, lengthening(mass, about, spacing, length))
    for text in found.warnings:
        warn(text)
    return found.periods, found.period_sds


def _document(result: YawInertia) -> dict[str, Any]:
    return {
        "yaw_inertia_kgm2": result.I_z,
        "sd": result.sd,
        "period_s": result.T,
        "period_sd_s": result.T_sd,
        "repeats": result.repeats,
        "total_kgm2": result.I_total,
        "tare_kgm2": result.I_tare,
    }


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="inertia", epilog=EXAMPLE)(inertia)
