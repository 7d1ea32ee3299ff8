"""Cases written to a folder, their labels sealed beside it."""

from __future__ import annotations

import gzip
import io
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.blind.bases import Base
from rcc_sim.blind.case import make_case
from rcc_sim.blind.seal import Seal, write_seal
from rcc_sim.blind.strengths import draws
from rcc_sim.errors import InputError
from rcc_sim.processes import working

KINDS = {"single": 0.5, "pair": 0.15, "null": 0.2, "unknown": 0.15}
"""Kinds of cases, and how often each is drawn."""
FAMILIES = ("rc", "ev")
SCHEMA = "rccsim.blind/1"


def labels_beside(out: Path) -> Path:
    """Where the labels of a folder of cases lie unless another place is named."""
    return out.with_name(out.name + ".labels.json")


def make(
    out: Path,
    *,
    cases: int,
    seed: int,
    kinds: Sequence[str] = tuple(KINDS),
    families: Sequence[str] = FAMILIES,
    base: Base | None = None,
    effects: Sequence[str] = (),
    repeats: int = 0,
    labels: Path | None = None,
    jobs: int = 1,
    done: Callable[[int], None] | None = None,
) -> Seal:
    """Write cases to ``out`` and their labels beside it; return the seal.

    Case k depends on the seed and k alone, so that more cases or more jobs leave
    those before as they are. If ``effects`` are asked for, one of them acts in each
    single and pair. Each drive is repeated so many times on a road as rough. ``done``
    is told how many are made.

    Raises
    ------
    InputError
        If ``out`` holds something already, or a kind, family or effect is unknown.
    """
    require_known("--kinds", kinds, KINDS)
    require_known("--family", families, FAMILIES)
    families = acted_on(families, base, effects)
    if cases < 1:
        raise InputError(f"--cases: should be at least 1: {cases}")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError(f"{out}: is not an empty folder", "cases are never mixed")
    labels = labels or labels_beside(out)
    if labels.resolve().is_relative_to(out.resolve()):
        raise InputError(f"{labels}: labels may not lie among the cases")
    if labels.exists():
        raise InputError(f"{labels}: is there already", "it may be another seal's key")
    out.parent.mkdir(parents=True, exist_ok=True)
    labels.parent.mkdir(parents=True, exist_ok=True)
    how = (seed, tuple(kinds), tuple(families), base, tuple(effects), repeats)
    made_by = {"seed": seed, "kinds": list(kinds), "families": list(families)}
    made_by |= {"effects": list(effects)} if effects else {}
    made_by |= {"repeats": repeats} if repeats else {}
    part = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.parent))
    try:  # the folder appears whole or not at all
        truth = {}
        for name, vehicle, logs, label in _made(cases, how, jobs):
            folder = part / name
            folder.mkdir()
            (folder / "vehicle.toml").write_text(vehicle, encoding="utf-8")
            for drive, data in logs.items():
                (folder / f"{drive}.csv.gz").write_bytes(data)
            truth[name] = label
            if done is not None:
                done(len(truth))
        truth = dict(sorted(truth.items()))
        seal = write_seal(part, labels, {"schema": SCHEMA, **made_by, "cases": truth})
        part.chmod(0o755)
        if out.exists():
            out.rmdir()  # empty, as was seen above
        part.replace(out)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return seal


def acted_on(
    families: Sequence[str], base: Base | None, effects: Sequence[str]
) -> list[str]:
    """Return the families in which one of some effects may act; all, if none is asked.

    Raises
    ------
    InputError
        Naming an effect that may act in none of them.
    """
    if not effects:
        return list(families)
    lossy = base is not None and base.loss > 0
    families = [base.family] if base else families
    may = {family: draws(family, lossy, effects) for family in families}
    require_known(
        "--effects", effects, sorted({n for pool in may.values() for n in pool})
    )
    return [family for family in families if {*effects} & {*may[family]}]


def require_known(
    what: str, names: Sequence[str], known: Sequence[str] | Mapping[str, Any]
) -> None:
    """Raise unless each name is known.

    Raises
    ------
    InputError
        Naming the first that is not.
    """
    if not names:
        raise InputError(f"{what}: should name at least one of {', '.join(known)}")
    for name in names:
        if name not in known:
            raise InputError(
                f"{what}: none is called {name!r}", f"known: {', '.join(known)}"
            )


Made = tuple[str, str, dict[str, bytes], dict[str, Any]]


def _made(cases: int, how: tuple[Any, ...], jobs: int) -> Iterator[Made]:
    yield _one(how, 0)  # compiles once, before others read the kernel's cache
    with working(_one, how, min(jobs, cases - 1)) as done:
        for _, made in done((k, k) for k in range(1, cases)):
            yield made


def _one(how: tuple[Any, ...], k: int) -> Made:
    """Make one case; alone in its process, and from the seed and its number alone."""
    seed, kinds, families, base, effects, repeats = how
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(k,)))
    shares = np.array([KINDS[kind] for kind in kinds])
    kind = str(rng.choice(list(kinds), p=shares / shares.sum()))
    name = f"c{k:04d}"
    case = make_case(name, kind, rng, families, base, effects, repeats)
    logs = {part: packed(columns) for part, columns in case.logs.items()}
    return name, case.vehicle, logs, case.label


def packed(columns: Mapping[str, NDArray[np.float64]]) -> bytes:
    """Return columns as compressed CSV; the same columns give the same bytes."""
    import pyarrow
    import pyarrow.csv

    table = pyarrow.table(dict(columns))
    text = io.BytesIO()
    text.write((",".join(columns) + "\n").encode())
    options = pyarrow.csv.WriteOptions(include_header=False)
    pyarrow.csv.write_csv(table, text, options)
    return gzip.compress(text.getvalue(), compresslevel=4, mtime=0)
