"""`rccsim step`: B and J from a step of the motor, wheels off the ground."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.complete import vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, emit, warn

if TYPE_CHECKING:
    from rcc_sim.identify.step_response import DampingAndInertia
    from rcc_sim.trace import Trace


EXAMPLE = "Example: rccsim step --speed 527 --torque 0.0067 --time-constant 0.196"


def step(
    log: Annotated[
        str | None,
        typer.Argument(
            help="Step log with time_s, motor_speed_radps and motor_torque_nm or "
            "motor_current_a; - is stdin."
        ),
    ] = None,
    speed: Annotated[
        float | None, typer.Option(help="Steady motor speed. [rad/s]")
    ] = None,
    torque: Annotated[
        float | None, typer.Option(help="Steady motor torque. [N m]")
    ] = None,
    time_constant: Annotated[float | None, typer.Option(help="[s]")] = None,
    speed_sd: Annotated[float, typer.Option(help="[rad/s]")] = 0.0,
    torque_sd: Annotated[float, typer.Option(help="[N m]")] = 0.0,
    time_constant_sd: Annotated[float, typer.Option(help="[s]")] = 0.0,
    closed_loop: Annotated[
        bool | None,
        typer.Option(
            "--closed-loop/--open-loop",
            help="Whether the step was in the speed reference, or in the torque.",
        ),
    ] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="Whose torque constant turns current into torque.",
            autocompletion=vehicle_names,
        ),
    ] = None,
    motion_threshold: Annotated[
        float, typer.Option(help="Motor speed that counts as turning. [rad/s]")
    ] = 5.0,
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """Damping B and inertia J at the motor shaft, with their uncertainty.

    From three figures, or fitted to a log: Coulomb and viscous drag from the steady
    states first, then J from the transients. What the record cannot tell is said.
    """
    if log is not None:
        document = _from_log(log, vehicle, motion_threshold, closed_loop)
    else:
        document = _from_figures(
            {"speed": speed, "torque": torque, "time_constant": time_constant},
            {
                "speed_sd": speed_sd,
                "torque_sd": torque_sd,
                "time_constant_sd": time_constant_sd,
            },
            closed_loop,
        )
    emit(document, [_flat(document)], json=json, csv=csv, output=output)


def _from_figures(
    figures: dict[str, float | None], sds: dict[str, float], closed_loop: bool | None
) -> dict[str, Any]:
    from rcc_sim.errors import InputError
    from rcc_sim.identify.step_response import damping_and_inertia

    missing = [f"--{k.replace('_', '-')}" for k, v in figures.items() if v is None]
    if missing:
        raise InputError(
            f"step: {', '.join(missing)}: missing",
            "give a log, or --speed, --torque and --time-constant",
        )
    given = {k: v for k, v in figures.items() if v is not None}
    result: DampingAndInertia = damping_and_inertia(
        **given, **sds, closed_loop=closed_loop
    )
    for text in result.warnings:
        warn(text)
    return {
        "damping_nms_per_rad": result.B,
        "damping_sd": result.B_sd,
        "inertia_kgm2": result.J,
        "inertia_sd": result.J_sd,
        "variance_share": {"damping": result.B_budget, "inertia": result.J_budget},
    }


def _from_log(
    log: str, vehicle: str | None, motion_threshold: float, closed_loop: bool | None
) -> dict[str, Any]:
    from rcc_sim.identify.step_response import fit_step, fit_time_constant
    from rcc_sim.trace import read_trace

    trace = read_trace(log)
    time, omega = trace["time_s"], trace["motor_speed_radps"]
    torque = _torque(trace, vehicle)
    if torque is None:
        constant = fit_time_constant(
            time, omega, closed_loop=closed_loop, motion_threshold=motion_threshold
        )
        for text in constant.warnings:
            warn(text)
        return {
            "time_constant_s": constant.T,
            "time_constant_sd": constant.T_sd,
            "inertia_over_damping_s": constant.inertia_over_damping,
            "overshoot": constant.overshoot,
            "transients": constant.transients,
            "r_squared": constant.r_squared,
        }
    fit = fit_step(time, omega, torque, motion_threshold=motion_threshold)
    for text in fit.warnings:
        warn(text)
    return {
        "damping_nms_per_rad": fit.B,
        "damping_sd": fit.B_sd,
        "friction_torque_nm": fit.T_C,
        "friction_torque_sd": fit.T_C_sd,
        "inertia_kgm2": fit.J,
        "inertia_sd": fit.J_sd,
        "r_squared_steady": fit.r_squared_steady,
        "r_squared_transient": fit.r_squared_transient,
        "steady_states": fit.steady_states,
        "transients": fit.transients,
        "below_threshold": fit.below_threshold,
        "converged": fit.converged,
        "correlation": fit.correlation,
        "identifiable": fit.identifiable,
    }


def _torque(trace: Trace, vehicle: str | None) -> Any:
    from rcc_sim.analyse.gap_energy import shaft_torque
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.errors import InputError

    if trace.has("motor_torque_nm"):
        return trace["motor_torque_nm"]
    if not trace.has("motor_current_a"):
        return None
    if vehicle is None:
        raise InputError(
            f"{trace.name}: motor_torque_nm: missing",
            "there is motor_current_a: name the car with --vehicle, "
            "whose torque constant makes it a torque",
        )
    torque = shaft_torque(trace.columns, load_vehicle(vehicle))
    if torque is None:
        raise InputError(f"{vehicle}: motor.poles, motor.flux_linkage_wb: missing")
    return torque


def _flat(document: dict[str, Any]) -> dict[str, Any]:
    return {k: v for k, v in document.items() if isinstance(v, int | float | None)}


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="step", epilog=EXAMPLE)(step)
