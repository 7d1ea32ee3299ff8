"""Every case diagnosed, out of sight of any label; judged on its fresh drive."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from rcc_sim.blind.seal import read_seal
from rcc_sim.errors import InputError
from rcc_sim.files import atomic

RESULTS = "results"
SEEN, AGAIN = ("vehicle.toml", "log.csv.gz"), "repeat*.csv.gz"
"""What a diagnosis sees of a case, and its repeats; the fresh drive comes into sight
afterwards."""
LIMIT = 300.0  # s for one command
INTERRUPTED = 130  # exit status of a command that was interrupted

Command = Callable[[Sequence[str], Path], dict[str, Any]]


class NoAnswer(Exception):
    """A command gave no result; says why."""


class Killed(NoAnswer):
    """A command was ended from outside: no answer of its own, and none is kept."""


def rccsim(words: Sequence[str], folder: Path) -> dict[str, Any]:
    """Run ``rccsim`` in a folder, in a process of its own; its JSON.

    Raises
    ------
    NoAnswer
        If it fails, takes too long, or prints no JSON.
    """
    command = [sys.executable, "-m", "rcc_sim", *words]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, cwd=folder, timeout=LIMIT
        )
    except subprocess.TimeoutExpired:
        raise NoAnswer(f"took more than {LIMIT:g} s") from None
    if done.returncode < 0 or done.returncode == INTERRUPTED:
        raise Killed(f"ended from outside ({done.returncode})")
    if done.returncode not in (0, 1):
        lines = done.stderr.strip().splitlines() or ["no message"]
        raise NoAnswer(next((x for x in lines if x.startswith("error")), lines[-1]))
    try:
        answer: dict[str, Any] = json.loads(done.stdout)
    except ValueError as error:
        raise NoAnswer(f"stdout is not JSON: {error}") from None
    return answer


def run(
    out: Path,
    *,
    jobs: int = 1,
    only: Sequence[str] = (),
    again: bool = False,
    command: Command = rccsim,
) -> Iterator[dict[str, Any]]:
    """Diagnose the cases of a folder; yield a line for each as soon as it is done.

    Results go to ``out/results``: NAME.json, the mended vehicle NAME.toml, and the
    profiles NAME.profiles.csv. What is there already is not done again, unless
    ``again``; a case that was ended from outside leaves nothing, and is done next time.
    Lines hold how many are ``done`` and how many there are ``of``.

    Raises
    ------
    InputError
        If the folder was not written by ``blind make``, or has no such case.
    """
    names = read_seal(out)["cases"]
    for name in only:
        if name not in names:
            raise InputError(f"--only: {out} has no case {name!r}")
    results = out / RESULTS
    results.mkdir(exist_ok=True)
    wanted = [n for n in names if not only or n in only]
    todo = [n for n in wanted if again or not (results / f"{n}.json").exists()]
    with ThreadPoolExecutor(jobs) as pool:
        orders = [pool.submit(_one, out, name, command) for name in todo]
        try:
            for done, order in enumerate(as_completed(orders), start=1):
                yield {"done": done, "of": len(todo), **order.result()}
        finally:  # interrupted, or no longer wanted
            for order in orders:
                order.cancel()


def _one(out: Path, name: str, command: Command) -> dict[str, Any]:
    """Diagnose one case and measure its gap on the fresh drive, before and after."""
    result: dict[str, Any] = {"case": name, "error": ""}
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "case"
        folder.mkdir()
        repeats = sorted(path.name for path in (out / name).glob(AGAIN))
        for file in (*SEEN, *repeats):
            shutil.copyfile(out / name / file, folder / file)
        again = [word for file in repeats for word in ("--repeats", file)]
        start = time.perf_counter()
        try:
            result["diagnosis"] = command((*DIAGNOSE, *again), folder)
            result["seconds"] = time.perf_counter() - start
            shutil.copyfile(out / name / "fresh.csv.gz", folder / "fresh.csv.gz")
            result["fresh"] = {
                when: _gap(vehicle, folder, command)
                for when, vehicle in (("before", "vehicle.toml"), ("after", FIXED))
                if (folder / vehicle).exists()
            }
        except Killed as error:
            return _line(name, "killed", [], time.perf_counter() - start, str(error))
        except NoAnswer as error:
            result["error"] = str(error)
            result.setdefault("seconds", time.perf_counter() - start)
        for file, suffix in ((FIXED, ".toml"), (PROFILES, ".profiles.csv")):
            if (folder / file).exists():
                shutil.copyfile(folder / file, out / RESULTS / f"{name}{suffix}")
    with atomic(out / RESULTS / f"{name}.json") as answer:
        answer.write(json.dumps(result, indent=1) + "\n")
    diagnosis = result.get("diagnosis", {})
    status, causes = diagnosis.get("status", "failed"), diagnosis.get("causes", [])
    return _line(name, status, causes, result["seconds"], result["error"])


def _line(
    name: str,
    status: str,
    causes: Sequence[dict[str, Any]],
    seconds: float,
    error: str,
) -> dict[str, Any]:
    named = ", ".join(c["effect"] for c in causes)
    return {"case": name, "status": status, "causes": named, "seconds": seconds,
            "error": error}  # fmt: skip


FIXED = "fixed.toml"
PROFILES = "profiles.csv"
DIAGNOSE = (
    "diagnose", "log.csv.gz", "--vehicle", "vehicle.toml", "--json",
    "--write-vehicle", FIXED, "--profiles", PROFILES,
)  # fmt: skip


def _gap(vehicle: str, folder: Path, command: Command) -> dict[str, Any]:
    words = ("gap", "fresh.csv.gz", "--vehicle", vehicle, "--json")
    answer = command(words, folder)
    where: dict[str, Any] = answer.get("where", answer)
    return {key: where[key] for key in ("energy", "channels") if key in where}


def read_results(out: Path) -> dict[str, dict[str, Any]]:
    """Return the results of each case that was run, by name.

    Raises
    ------
    InputError
        If one of them cannot be read.
    """
    found = {}
    for path in sorted((out / RESULTS).glob("[!.]*.json")):
        try:
            found[path.stem] = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            hint = f"`rccsim blind run {out} --only {path.stem} --again` makes it anew"
            raise InputError(f"{path}: not JSON: {error}", hint) from None
    return found
