"""FASTSim 3 on the rows of the EPA's list, set up as FASTSim's own importer does.

Its importer (NREL/fastsim, vehicle_import.rs of version 2.1) gives every electric car
trans_eff 0.98, aux_kw 0.25, the motor's curve with its peak at 0.95 over the motor's
power, and the drag and rolling resistance that fit A, B, C below 70 mph; the battery's
0.97 round trip and the charger's 0.86 are FASTSim's defaults. FASTSim 3 ships the same
curve and battery with its Renault Zoe, which is the vehicle that is changed here. The
fit is by least squares over speed; a user gives the importer the motor's power, for
which the list's rating stands.
"""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.epa_tests import HP, KWH, LB, LBF, MILE, MPH, POWER, WEIGHT, A, B, C

CHARGER = 0.86  # FASTSim 2.1: parameters.py, chg_eff
AUXILIARY = 250.0  # W; the importer's
TRANSMISSION = 0.98
TOP_SPEED = 70.0 * MPH  # m/s; the importer's
AREA = 2.5  # m²; only its product with the drag coefficient matters
G = 9.80  # m/s²; FASTSim's rolling resistance has this
PLAUSIBLE = 50.0  # W/kg; ratings below are misprints (Kona: 37 hp)
SPARE = 1e6  # W; what the battery may give, so that it never limits


def version() -> str:
    """Return FASTSim's version."""
    from importlib.metadata import version as installed

    return installed("fastsim")


def drag(test: pd.Series) -> tuple[float, float]:
    """Return drag and rolling coefficients that fit a row's road load. [1]"""
    import fastsim

    v = np.linspace(0.0, TOP_SPEED, 300)
    force = float(test[A]) * LBF + v * (
        float(test[B]) * LBF / MPH + v * float(test[C]) * LBF / MPH**2
    )
    terms = np.column_stack([np.ones_like(v), v * v])
    constant, square = np.linalg.lstsq(terms, force)[0]
    m = float(test[WEIGHT]) * LB
    density = fastsim.Air.get_density()
    return square / (0.5 * density * AREA), constant / (m * G)


def motor_power(tests: pd.DataFrame) -> NDArray[np.float64]:
    """Return the rating of each row's motor, by weight where it is a misprint. [W]"""
    m = tests[WEIGHT].to_numpy() * LB
    per_mass = tests[POWER].to_numpy() * HP / m
    return m * np.where(per_mass < PLAUSIBLE, np.median(per_mass), per_mass)


def car_of(
    base: dict[str, Any], test: pd.Series, power: float, auxiliary: float
) -> Any:
    """Return FASTSim's vehicle for a row."""
    import fastsim

    model = dict(base)
    drag_coefficient, rolling = drag(test)
    model["pwr_aux_base_watts"] = auxiliary
    model["mass_kilograms"] = float(test[WEIGHT]) * LB
    model["chassis"] = base["chassis"] | {
        "glider_mass_kilograms": None,  # parts would have to add up to the mass
        "cargo_mass_kilograms": None,
        "wheel_rr_coef": rolling,
        "drag_coef": drag_coefficient,
        "frontal_area_square_meters": AREA,
    }
    parts = model["pt_type"]["BEV"]
    parts["em"]["pwr_out_max_watts"] = power
    parts["res"]["pwr_out_max_watts"] = SPARE
    parts["transmission"]["eff_interp"] = TRANSMISSION
    return fastsim.Vehicle.from_dict(model)


def battery_energies(
    tests: pd.DataFrame, auxiliary: float = AUXILIARY
) -> NDArray[np.float64] | None:
    """Return the energy from the battery's cells, one per row. [kWh/100 mi]

    None where FASTSim 3 is not installed.
    """
    if importlib.util.find_spec("fastsim") is None or not version().startswith("3."):
        return None
    import fastsim

    base = fastsim.Vehicle.from_resource("2022_Renault_Zoe_ZE50_R135.yaml").to_dict()
    cycles = {
        name: fastsim.Cycle.from_resource(f"{file}.csv")
        for name, file in (("udds", "udds"), ("hwfet", "hwfet"))
    }
    found = []
    for (_, test), power in zip(tests.iterrows(), motor_power(tests), strict=True):
        drive = fastsim.SimDrive(
            car_of(base, test, power, auxiliary), cycles[test["cycle"]]
        )
        drive.run()
        after = drive.to_dict()["veh"]
        used = after["pt_type"]["BEV"]["res"]["state"]["energy_out_chemical_joules"]
        distance = after["state"]["dist_meters"]
        found.append(used / KWH / (distance / (100 * MILE)))
    return np.array(found)
