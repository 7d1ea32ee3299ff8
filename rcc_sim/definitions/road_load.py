"""Road load two ways: as certified, A + B v + C v², and as rolling, air and shaft."""

from __future__ import annotations

from typing import Any

from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError, require_positive
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.units import G, unit_of

KEYS = ("a_n", "b_n_s_per_m", "c_n_s2_per_m2")


def two_terms(
    A: float, B: float, C: float, *, m: float, v_max: float, rho: float
) -> dict[str, float]:
    r"""Rolling coefficient and drag area nearest to a certified road load.

    .. math:: C_{rr} m g = A + 3 B V / 16, \quad \rho C_d A / 2 = C + 15 B / (16 V)

    the least-squares line in 1 and v² through A + B v + C v², speeds 0 to V alike; it
    is exact where B = 0, and off by 3 B V / 16 at most, at standstill.

    Parameters
    ----------
    A, B, C : float
        Certified coefficients. [N], [N s/m], [N s²/m²]
    m, v_max, rho : float
        Mass [kg], largest speed V [m/s], density of the air [kg/m³].

    Returns
    -------
    terms : dict
        ``coefficient``, ``drag_area_m2`` and ``worst_n``, the largest difference. [N]

    Raises
    ------
    InputError
        If one of them would be negative, or mass, speed or density is not positive.
    """
    require_positive(mass_kg=m, max_speed_mps=v_max, air_density_kg_per_m3=rho)
    terms = {
        "coefficient": (A + 3.0 * B * v_max / 16.0) / (m * G),
        "drag_area_m2": 2.0 * (C + 15.0 * B / (16.0 * v_max)) / rho,
    }
    for name, value in terms.items():
        if value < 0:
            raise InputError(
                f"road load: {name}: would be negative: {value:.3g}",
                "A, B and C are only meant together: keep effects.road_load, or choose "
                "another largest speed",
            )
    return terms | {"worst_n": 3.0 * abs(B) * v_max / 16.0}


def converted(vehicle: Vehicle, v_max: float) -> list[dict[str, Any]]:
    """Return a vehicle's road load stated the other way, a row a figure.

    A certified one becomes rolling resistance, drag and damping of the shaft, B / n²,
    which is exact, and rolling resistance and drag alone, up to v_max [m/s]; the parts
    become A, B and C, with dry friction at the shaft in A.

    Raises
    ------
    InputError
        If the vehicle states no road load at all, or a part would be negative.
    """
    n = vehicle.rad_per_m
    m = vehicle.body.mass_kg.value
    rho = _stated(vehicle, "aerodynamic_drag", "air_density_kg_per_m3")
    if "road_load" in vehicle.effects:
        A, B, C = (_stated(vehicle, "road_load", key) for key in KEYS)
        rows: list[dict[str, Any]] = []
        if min(A, B, C) >= 0:
            exact = {
                "effects.rolling_resistance.coefficient": A / (m * G),
                "effects.aerodynamic_drag.drag_area_m2": 2.0 * C / rho,
                "effects.drivetrain_damping.damping_nms_per_rad": B / (n * n),
            }
            rows += [_row(key, value, "exact") for key, value in exact.items()]
        near = two_terms(A, B, C, m=m, v_max=v_max, rho=rho)
        how = f"fitted up to {v_max:g} m/s, {near['worst_n']:.3g} N off at most"
        two = {
            "effects.rolling_resistance.coefficient": near["coefficient"],
            "effects.aerodynamic_drag.drag_area_m2": near["drag_area_m2"],
        }
        return rows + [_row(key, value, how) for key, value in two.items()]
    parts = EFFECTS["road_load"].excludes
    if not any(name in vehicle.effects for name in parts):
        raise InputError(
            f"{vehicle.where}: states no road load",
            f"{', '.join(parts)} or road_load: --with adds one",
        )
    C_rr = _stated(vehicle, "rolling_resistance", "coefficient")
    friction = _stated(vehicle, "drivetrain_friction", "torque_nm")
    damping = _stated(vehicle, "drivetrain_damping", "damping_nms_per_rad")
    C_dA = _stated(vehicle, "aerodynamic_drag", "drag_area_m2")
    figures = (C_rr * m * G + n * friction, n * n * damping, 0.5 * rho * C_dA)
    return [
        _row(f"effects.road_load.{key}", value, "exact")
        for key, value in zip(KEYS, figures, strict=True)
    ]


def _stated(vehicle: Vehicle, effect: str, key: str) -> float:
    figure = vehicle.figures().get(f"effects.{effect}.{key}")
    return figure.value if figure else EFFECTS[effect].neutral[key]


def _row(key: str, value: float, how: str) -> dict[str, Any]:
    return {"key": key, "value": value, "unit": unit_of(key), "how": how}
