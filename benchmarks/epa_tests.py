"""The electric cars of the EPA's 2022 test-car list: tests, halves, scores."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[1]
LIST = ROOT.parent / "shared/data/real_ev/epa_roadload"
DEFAULT = LIST / "epa_2022_test_car_list_electric.csv"
CYCLES = {81: "udds", 84: "hwfet"}  # EPA test procedure -> cycle

LBF = 4.4482216152605  # N; exact
LB = 0.45359237  # kg; exact
MPH = 0.44704  # m/s; exact
HP = 745.6998715822702  # W; 550 ft lbf/s
MILE = 1609.344  # m; exact
KWH = 3.6e6  # J; exact
GALLON = 33.705  # kWh; energy of a gallon of petrol; the EPA's figure
MPGE_ABOVE = 60.0  # the list's unit column is wrong; above this MPGe, else kWh/100 mi

A, B, C = (f"Target Coef {k}" for k in ("A (lbf)", "B (lbf/mph)", "C (lbf/mph**2)"))
WEIGHT, POWER = "Equivalent Test Weight (lbs.)", "Rated Horsepower"
MODEL, MAKE = "Represented Test Veh Model", "Represented Test Veh Make"

FAMILIES = {  # what a model's name holds -> family; the first that fits
    "e-tron gt": "j1", "taycan": "j1",  # one platform of Audi and Porsche
    "q4": "meb", "id.4": "meb", "e-tron": "e-tron",
    "ioniq": "e-gmp", "ev6": "e-gmp", "kona": "kona", "niro": "kona",
    "model 3": "model 3", "model y": "model 3",
    "model s": "model s", "model x": "model s",
    "i4": "i4", "ix": "ix", "mini": "mini", "mach-e": "mach-e", "bolt": "bolt",
    "i-pace": "i-pace", "lucid": "air", "mx-30": "mx-30", "eqs": "eqs",
    "leaf": "leaf", "r1": "r1",
    "polestar": "cma", "c40": "cma", "xc40": "cma",
}  # fmt: skip


@dataclass(frozen=True)
class Score:
    """How far predictions lie from the list.

    Parameters
    ----------
    rows : int
    mean_abs, median_abs, bias : float
        Of (predicted - listed) / listed. [%]
    """

    rows: int
    mean_abs: float
    median_abs: float
    bias: float


def read_tests(path: Path) -> pd.DataFrame:
    """Return the tests that can be predicted, with the wall energy. [kWh/100 mi]"""
    tests = pd.read_csv(path)
    tests = tests[tests["Test Procedure Cd"].isin(CYCLES)]
    tests = tests.dropna(subset=[A, B, C, WEIGHT, "RND_ADJ_FE"]).reset_index(drop=True)
    value = tests["RND_ADJ_FE"]
    is_mpge = value > MPGE_ABOVE
    families = tests[MODEL].map(family)
    return tests.assign(
        cycle=tests["Test Procedure Cd"].map(CYCLES),
        listed=np.where(is_mpge, 100 * GALLON / value, value),
        family=families,
        held_out=families.isin(held_out_families(families)),
    )


def family(model: str) -> str:
    """Return the family of cars that share a model's platform or motors."""
    name = model.lower()
    return next((f for part, f in FAMILIES.items() if part in name), name)


def held_out_families(families: pd.Series) -> list[str]:
    """Return every second family in the order of the alphabet."""
    return sorted(families.unique())[1::2]


def score(error: NDArray[np.float64]) -> Score:
    """Return rows, mean and median absolute error, and bias."""
    size = np.abs(error)
    return Score(
        len(error), float(size.mean()), float(np.median(size)), float(error.mean())
    )


def likely_reason(tests: pd.DataFrame, error: NDArray[np.float64], at: int) -> str:
    """Return what about a row may explain its error; a guess, and no more."""
    row = tests.iloc[at]
    same = (tests[[MODEL, WEIGHT, A, B, C]] == row[[MODEL, WEIGHT, A, B, C]]).all(
        axis=1
    )
    other = tests[same & (tests["cycle"] != row["cycle"])]["listed"].mean()
    mine = row["listed"]
    ratio = mine / other if row["cycle"] == "udds" else other / mine
    if not 0.7 <= ratio <= 1.3:
        return (
            f"value or unit doubtful: {row['RND_ADJ_FE']:g} is {mine:.1f} beside"
            f" {other:.1f} on the other cycle"
        )
    if (np.abs((1 + error[same] / 100) / 0.7 - 1) < 0.12).all():
        return "all its tests fit if the list has them times 0.7 already, as a label"
    twins = tests[same & (tests["cycle"] == row["cycle"])]["listed"]
    spread = 100 * (twins.max() / twins.min() - 1)
    if spread > 5:
        return f"same car listed more than once, {spread:.0f} % apart"
    make = tests[MAKE].str.upper() == row[MAKE].upper()
    peers = np.asarray(make & (tests["cycle"] == row["cycle"]) & ~same)
    if peers.sum() >= 3 and np.median(error[peers]) * np.sign(error[at]) > 5:
        return (
            f"shared by the make: its other {peers.sum()} tests on this cycle lie"
            f" {np.median(error[peers]):+.0f} % off; one set of losses does not fit it"
        )
    return "none seen in the list"


def show_head(what: str) -> None:
    """Print the head of a table of scores."""
    print(f"{what:63s} rows       both           udds           hwfet")


def show_scores(tests: pd.DataFrame, error: NDArray[np.float64], what: str) -> None:
    """Print a line: both cycles, then each."""
    line = f"  {what:61s}{len(tests):5d}"
    for name in ("both", "udds", "hwfet"):
        part = np.full(len(tests), True) if name == "both" else tests["cycle"] == name
        s = score(error[np.asarray(part)])
        line += f"   {s.mean_abs:5.1f} {s.bias:+6.1f}"
    print(line)


def show_worst(tests: pd.DataFrame, error: NDArray[np.float64], count: int = 5) -> None:
    """Print the models farthest off, by their worst row, with what may be why."""
    order = np.argsort(-np.abs(error), kind="stable")
    first = ~tests[MODEL].iloc[order].duplicated().to_numpy()
    for at in order[first][:count]:
        row = tests.iloc[at]
        print(
            f"  {error[at]:+6.1f} %  {row[MAKE]} {row[MODEL]}, {row['cycle']}, listed"
            f" {row['listed']:.1f} kWh/100 mi: {likely_reason(tests, error, int(at))}"
        )
