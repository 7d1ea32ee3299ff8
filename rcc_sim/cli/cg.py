"""`rccsim cg`: where the centre of mass is, and what ballast moves it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.output import Csv, Json, Output, emit

if TYPE_CHECKING:
    from rcc_sim.identify.cg import CentreOfGravity


EXAMPLE = (
    "Example: rccsim cg --wheelbase 0.324 --front 1.93 --rear 1.85; rccsim cg "
    "--wheelbase 0.324 --balance 0.15 --mass 3.6 --target 0.159 --ballast-mass "
    "0.2"
)


def cg(
    wheelbase: Annotated[float, typer.Option(help="[m]")],
    front: Annotated[
        float | None, typer.Option(help="What the front axle weighs. [kg]")
    ] = None,
    rear: Annotated[
        float | None, typer.Option(help="What the rear axle weighs. [kg]")
    ] = None,
    balance: Annotated[
        float | None,
        typer.Option(help="Point of balance behind the front axle. [m]"),
    ] = None,
    mass: Annotated[
        float | None, typer.Option(help="Of the car, where not weighed. [kg]")
    ] = None,
    target: Annotated[
        float | None,
        typer.Option(help="Where the centre should be, behind the front axle. [m]"),
    ] = None,
    ballast_mass: Annotated[
        float | None, typer.Option(help="Ballast at hand: where to put it. [kg]")
    ] = None,
    ballast_position: Annotated[
        float | None,
        typer.Option(help="Place at hand, behind the front axle: how much. [m]"),
    ] = None,
    wheelbase_sd: Annotated[float, typer.Option(help="[m]")] = 0.0,
    scale_sd: Annotated[float, typer.Option(help="Of the scales. [kg]")] = 0.0,
    balance_sd: Annotated[float, typer.Option(help="[m]")] = 0.0,
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """l_F and l_R by axle weights or a balance point, and ballast that moves them."""
    from rcc_sim.errors import InputError
    from rcc_sim.identify import cg as centre

    if balance is not None and front is None and rear is None:
        place = centre.cg_from_balance(
            wheelbase, balance, l_sd=wheelbase_sd, balance_sd=balance_sd
        )
    elif front is not None and rear is not None and balance is None:
        place = centre.cg_from_scales(
            wheelbase, front, rear, l_sd=wheelbase_sd, scale_sd=scale_sd
        )
    else:
        raise InputError("cg: give --front and --rear, or --balance")
    row = _document(place)
    if target is not None:
        row |= _ballast(place, mass, target, ballast_mass, ballast_position)
    emit(row, [row], json=json, csv=csv, output=output)


def _document(place: CentreOfGravity) -> dict[str, Any]:
    return {
        "cg_to_front_axle_m": place.l_F,
        "cg_to_front_axle_sd": place.l_F_sd,
        "cg_to_rear_axle_m": place.l_R,
        "cg_to_rear_axle_sd": place.l_R_sd,
        "mass_kg": place.m,
    }


def _ballast(
    place: CentreOfGravity,
    mass: float | None,
    target: float,
    ballast_mass: float | None,
    ballast_position: float | None,
) -> dict[str, Any]:
    from rcc_sim.errors import InputError
    from rcc_sim.identify.cg import ballast

    m = place.m if place.m is not None else mass
    if m is None:
        raise InputError("cg: --target needs the car's mass: give --mass")
    found = ballast(
        m, place.l_F, place.l, target, mass=ballast_mass, position=ballast_position
    )
    return {
        "ballast_mass_kg": found.mass,
        "ballast_position_m": found.position,
        "loaded_mass_kg": found.m,
        "loaded_cg_to_front_axle_m": found.l_F,
        "loaded_cg_to_rear_axle_m": found.l_R,
        "yaw_inertia_change_kgm2": found.I_z_change,
    }


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="cg", epilog=EXAMPLE)(cg)
