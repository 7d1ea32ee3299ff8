"""What many logs of one car say together: false alarms, and weak causes found.

    python -m benchmarks.pooled --fleets 24
    python -m benchmarks.pooled --fleets 4 --effect rolling_resistance --of 0.003

The car, its drives and its sensors are the blind plant's (`benchmarks.one_car`). With
`--alone` each log is diagnosed by itself too, which takes ten times as long.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path

from benchmarks.one_car import PLANT, write
from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.vehicle import Vehicle, load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.fleet.pool import Evidence, evidence_of
from rcc_sim.diagnose.fleet.pooled import pool
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose

BASES = {"slash": 30.0, "sedan": 120.0, "racer": 30.0, "pickup": 120.0}
"""Car -> length of its logs. [s]"""


def main() -> None:
    """Print a line a fleet, and the count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fleets", type=int, default=24)
    parser.add_argument("--logs", type=int, default=20)
    parser.add_argument("--effect", default="", choices=["", *PLANT])
    parser.add_argument("--of", type=float, default=0.0)
    parser.add_argument("--base", default="", choices=["", *BASES])
    parser.add_argument("--seed", type=int, default=100)
    parser.add_argument("--alone", action="store_true")
    known = parser.parse_args()
    right = named = 0
    most = 0.0
    for k in range(known.fleets):
        base = known.base or list(BASES)[k % len(BASES)]
        with tempfile.TemporaryDirectory() as folder:
            write(
                Path(folder), known.logs, effect=known.effect, of=known.of, base=base,
                seconds=BASES[base], seed=known.seed + k,
            )  # fmt: skip
            names = [str(p) for p in sorted(Path(folder, "logs").iterdir())]
            car = load_vehicle(Path(folder, "vehicle.toml"))
            start = time.perf_counter()
            found = pool({"car": [evidence(name, car) for name in names]})
            each = (time.perf_counter() - start) / known.logs
            alone = [causes(name, car) for name in names] if known.alone else []
        best = found.ranking[0]
        most = max(most, best.nats)
        told = [
            f"{c.found.effect} {c.found.value:.3g} ({c.found.low:.3g} to "
            f"{c.found.high:.3g}) {c.found.nats:.0f} nats, most in a log "
            f"{c.largest:.0f}, tied {list(c.tied)}"
            for c in found.causes
        ]
        named += bool(found.causes)
        right += any(
            known.effect in (c.found.effect, *c.tied) for c in found.causes[:1]
        )
        print(
            f"{base} {known.seed + k}: {told or 'no cause'}; best {best.effect} "
            f"{best.nats:.1f} nats; {each:.2f} s a log",
            flush=True,
        )
        if alone:
            count = sum(known.effect in one for one in alone)
            other = sum(bool(one) and known.effect not in one for one in alone)
            print(f"  alone: right in {count}, something else in {other}", flush=True)
    print(f"{named} of {known.fleets} fleets name a cause, {right} the right one; most")
    print(f"that any candidate gained: {most:.1f} nats")


def evidence(name: str, car: Vehicle) -> Evidence:
    """Return the evidence of a log, from the fit of its tolerances alone."""
    problems = [problem_of(open_log(name, car).log, car)]
    engine = Engine(problems)
    null = descent.fit(engine, {}, nuisance_knobs(problems))
    return evidence_of(engine, null, candidates_for(problems))


def causes(name: str, car: Vehicle) -> set[str]:
    """Return what a log names by itself, and what it cannot tell from it."""
    found = diagnose([open_log(name, car)], car)
    return {
        effect for a in found.asserted for effect in (a.cause.effect, *a.cause.tied)
    }


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    main()
