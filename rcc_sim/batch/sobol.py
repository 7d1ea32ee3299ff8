"""Which unknown figure makes how much of the spread: Sobol indices, by SALib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rcc_sim.batch.batch import rows_of
from rcc_sim.batch.draws import LARGEST, at_levels, uncertain_figures
from rcc_sim.batch.engine import Engine
from rcc_sim.batch.plan import Plan
from rcc_sim.batch.runs import Manoeuvre, Sweep
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError

CONFIDENCE = 0.9
"""Of the half-widths that stand beside the indices. [1]"""

NOISE = 1e-9
"""Relative spread below which a figure does not change at all. [1]"""


def sobol_indices(
    vehicle: Vehicle,
    cycle: Cycle,
    how: Manoeuvre,
    *,
    samples: int = 1024,
    of: Sequence[str] = ("wh_per_km",),
    ranges: Mapping[str, tuple[float, float]] | None = None,
    seed: int = 0,
    engine: Engine | None = None,
) -> list[dict[str, Any]]:
    """Return first-order and total Sobol indices, a row a figure and a key.

    Saltelli's sample and Jansen's estimators, as SALib has them; (d + 2) runs a sample
    of d keys. First order: the share of the variance that would go if the key were
    known; total: the share that would stay if all others were. [1]_

    Parameters
    ----------
    vehicle, cycle, how
        The run; every figure with an sd or a range that acts on it is drawn.
    samples : int
        Base samples; rounded up to a power of two.
    of : sequence of str
        Columns of a sweep that are asked about.
    ranges : mapping or None
        Further keys -> least and greatest value, uniform between.

    Raises
    ------
    InputError
        If SALib is not installed, nothing is uncertain, or a run fails.

    References
    ----------
    .. [1] A. Saltelli et al., "Variance based sensitivity analysis of model output,"
       Computer Physics Communications 181, 2010, 259-270.
    """
    analyze, sample = _salib()
    varied = {
        k: Figure((a + b) / 2, low=a, high=b) for k, (a, b) in (ranges or {}).items()
    }
    figures = uncertain_figures(vehicle, commanded=not how.imposed, fixed=tuple(varied))
    figures |= varied
    if len(figures) < 1:
        raise InputError(
            f"{vehicle.where}: states no sd and no range of what acts on this run",
            "give figures an sd, or --vary KEY=lo:hi",
        )
    d = len(figures)
    whole = 1 << max(samples - 1, 1).bit_length()
    if samples < 1 or whole * (d + 2) * d > LARGEST:
        most = 1 << ((LARGEST // ((d + 2) * d)).bit_length() - 1)
        raise InputError(
            f"--samples: should lie between 1 and {most:,} for {d} keys: {samples:,}"
        )
    problem = {"num_vars": d, "names": list(figures), "bounds": [[0.0, 1.0]] * d}
    u = sample(problem, whole, calc_second_order=False, seed=seed)
    keys = tuple(figures)
    plan = Plan((), keys, at_levels(vehicle, figures, u))
    sweep = Sweep(vehicle, cycle, plan, how)
    sweep.check()
    columns = _results(sweep, of, engine)
    rows: list[dict[str, Any]] = []
    for name in of:
        y = columns[name]
        if y.std() <= NOISE * max(abs(float(y.mean())), 1e-300):
            raise InputError(f"{name}: does not depend on any of the figures")
        found = analyze(
            problem,
            y,
            calc_second_order=False,
            conf_level=CONFIDENCE,
            seed=seed,
        )
        rows += [
            {
                "of": name,
                "key": keys[i],
                "first_order": float(found["S1"][i]),
                "first_order_half_width": float(found["S1_conf"][i]),
                "total": float(found["ST"][i]),
                "total_half_width": float(found["ST_conf"][i]),
            }
            for i in np.argsort(-found["ST"])
        ]
    return rows


def _results(sweep: Sweep, of: Sequence[str], engine: Engine | None) -> dict[str, Any]:
    import pyarrow

    parts = []
    for table in rows_of(sweep, engine):
        unknown = [name for name in of if name not in table.column_names]
        if unknown:
            known = [n for n in table.column_names if n not in sweep.plan.keys]
            raise InputError(
                f"--of {unknown[0]}: no such figure", f"there are {', '.join(known)}"
            )
        wrong = table.filter(pyarrow.compute.is_valid(table["error"]))
        if len(wrong):
            row = wrong.slice(0, 1).to_pylist()[0]
            raise InputError(
                f"run {row['run']}: {row['error']}",
                "indices need every run; narrow the sd or range that leads there",
            )
        parts.append(table.select(list(of)))
    whole = pyarrow.concat_tables(parts)
    return {name: whole[name].to_numpy() for name in of}


def _salib() -> tuple[Any, Any]:
    try:
        from SALib.analyze import sobol as analysis
        from SALib.sample import sobol as sampling
    except ImportError:
        raise InputError(
            "sensitivity: SALib is not installed",
            "python -m pip install 'rccsim[sensitivity]'",
        ) from None
    return analysis.analyze, sampling.sample
