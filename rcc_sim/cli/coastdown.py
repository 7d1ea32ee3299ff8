"""`rccsim coastdown`: road load from a coast-down."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.complete import vehicle_names
from rcc_sim.cli.logs import Map, trace_of
from rcc_sim.cli.output import Csv, Json, Output, emit, say, warn

if TYPE_CHECKING:
    from rcc_sim.definitions.vehicle import Vehicle
    from rcc_sim.identify.coastdown import RoadLoad
    from rcc_sim.identify.pooled import Pooled
    from rcc_sim.identify.slowing import Slowing

UNITS = {"A": "n", "B": "n_s_per_m", "C": "n_s2_per_m2"}
DRIVES = ("motor_torque_nm", "motor_current_a", "throttle")
COLUMNS = ("speed_mps", *DRIVES, "slope", "elevation_m")


EXAMPLE = "Example: rccsim coastdown coast.csv --vehicle rcc"


def coastdown(
    logs: Annotated[
        list[str],
        typer.Argument(help="Logs of any format that hold a speed; - is stdin."),
    ],
    mass: Annotated[float | None, typer.Option(help="As driven. [kg]")] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="Whose mass and rotating inertia to take.",
            autocompletion=vehicle_names,
        ),
    ] = None,
    equivalent_inertia: Annotated[
        float | None, typer.Option(help="Mass that the rotating parts add. [kg]")
    ] = None,
    min_speed: Annotated[
        float | None, typer.Option(help="Leave out rows below. [m/s]")
    ] = None,
    drive_threshold: Annotated[
        float | None,
        typer.Option(
            help="Torque, current or throttle up to which it is none; 2 % of its "
            "largest, or 4 sds of its noise, unless given."
        ),
    ] = None,
    direction: Annotated[
        list[int] | None,
        typer.Option(help="1 or -1 for each coast: both ways tell grade apart."),
    ] = None,
    map_: Map = None,
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """Road load A + B v + C v² from coast-downs, by fitting speed over time.

    Coasts are found where the motor gives nothing (torque, current or throttle in
    the log), else where the speed falls for longest. Several logs are fitted as one.
    Intervals hold 90 %.
    """
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.identify.coastdown import fit_coastdown
    from rcc_sim.identify.pooled import pooled
    from rcc_sim.identify.slowing import slowing

    car = load_vehicle(vehicle) if vehicle else None
    weight, turning = _mass(mass, car), _equivalent(equivalent_inertia, car)
    pool = pooled([trace_of(log, map_, car) for log in logs], COLUMNS)
    seen = pool.columns
    result = fit_coastdown(
        seen["time_s"],
        seen["speed_mps"],
        weight,
        equivalent_inertia_kg=turning,
        drive=next((seen[c] for c in DRIVES if c in seen), None),
        slope=seen.get("slope"),
        elevation_m=seen.get("elevation_m") if "slope" not in seen else None,
        direction=direction or None,
        min_speed_mps=min_speed,
        drive_threshold=drive_threshold,
    )
    for text in result.warnings:
        warn(text)
    if not result.converged:
        warn(f"the fit did not converge: {result.message}")
    slows = slowing(result, weight + turning)
    document = _document(result, pool, slows)
    emit(document, _rows(result), json=json, csv=csv, output=output)
    say(f"{len(result.stretches)} coasts, {result.speed_low:.3g} to "
        f"{result.speed_high:.3g} m/s")  # fmt: skip
    told = ", ".join(f"{s.deceleration_mps2:.3g} at {s.speed_mps:.2g}" for s in slows)
    say(f"slows by m/s² at m/s: {told}")


def _mass(mass: float | None, car: Vehicle | None) -> float:
    from rcc_sim.errors import InputError

    if mass is not None:
        return mass
    if car is None:
        raise InputError("coastdown: give --mass, or --vehicle to take its mass")
    return car.body.mass_kg.value


def _equivalent(given: float | None, car: Vehicle | None) -> float:
    from rcc_sim.physics.effects.rotor_inertia import reflected_mass

    if given is not None or car is None:
        return given or 0.0
    J = car.figures().get("effects.rotor_inertia.inertia_kgm2")
    n = car.rad_per_m
    return reflected_mass(J.value, n) if J else 0.0


def _rows(result: RoadLoad) -> list[dict[str, Any]]:
    named = [(n, getattr(result, n)) for n in ("A", "B", "C", "C_rr", "C_dA", "slope")]
    return [
        {
            "coefficient": name,
            "value": c.value,
            "sd": c.sd,
            "low": c.low,
            "high": c.high,
            "fitted": c.fitted,
        }
        for name, c in named
        if c is not None
    ]


def _document(
    result: RoadLoad, pool: Pooled, slows: Sequence[Slowing]
) -> dict[str, Any]:
    from dataclasses import asdict

    def own(start: float, end: float) -> dict[str, Any]:
        log, begin = pool.own(start)
        return {"log": log, "start_s": begin, "end_s": pool.own(end)[1]}

    load = {f"{k.lower()}_{u}": getattr(result, k).value for k, u in UNITS.items()}
    return load | {
        "coefficients": {row.pop("coefficient"): row for row in _rows(result)},
        "terms": list(result.terms),
        "r_squared": result.r_squared,
        "residual_sd_mps": result.residual_sd,
        "stretches": [own(a, b) for a, b in result.stretches],
        "decelerations": [asdict(s) for s in slows],
        "speed_low_mps": result.speed_low,
        "speed_high_mps": result.speed_high,
        "converged": result.converged,
    }


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="coastdown", epilog=EXAMPLE)(coastdown)
