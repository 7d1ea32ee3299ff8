"""Labels kept apart from the cases, and a hash that shows if they were touched."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcc_sim.errors import CheckFailed, InputError
from rcc_sim.files import atomic

SEAL = "seal.json"


@dataclass(frozen=True)
class Seal:
    """Where the labels are, how many cases they are of, and their SHA-256."""

    cases: list[str]
    labels: Path
    sha256: str


def write_seal(out: Path, labels: Path, truth: dict[str, Any]) -> Seal:
    """Write the labels, and their hash among the cases.

    The seal names the cases and the hash and nothing that tells of a label: neither
    the seed, from which all could be drawn again, nor kinds.
    """
    text = json.dumps(truth, indent=1, sort_keys=True) + "\n"
    with atomic(labels) as file:
        file.write(text)
    digest = hashlib.sha256(text.encode()).hexdigest()
    names = sorted(truth["cases"])
    seal = {"schema": truth["schema"], "sha256": digest, "cases": names}
    with atomic(out / SEAL) as file:
        file.write(json.dumps(seal, indent=1) + "\n")
    return Seal(names, labels, digest)


def read_seal(out: Path) -> dict[str, Any]:
    """Return what the seal among the cases says.

    Raises
    ------
    InputError
        If there is none, or it is not one.
    """
    path = out / SEAL
    try:
        seal = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        hint = "`rccsim blind make` writes such a folder"
        raise InputError(f"{path}: {error.strerror}", hint) from None
    except ValueError as error:
        raise InputError(f"{path}: not JSON: {error}") from None
    if not isinstance(seal, dict) or not {"sha256", "cases"} <= seal.keys():
        raise InputError(f"{path}: should hold sha256 and cases")
    return seal


def opened(out: Path, labels: Path) -> dict[str, Any]:
    """Return the labels, if they are those that were sealed.

    Raises
    ------
    CheckFailed
        If their hash is not the seal's.
    """
    seal = read_seal(out)
    try:
        data = labels.read_bytes()
    except OSError as error:
        hint = "the labels that `rccsim blind make` wrote, where --labels said"
        raise InputError(f"{labels}: {error.strerror}", hint) from None
    digest = hashlib.sha256(data).hexdigest()
    if digest != seal["sha256"]:
        raise CheckFailed(
            f"{labels}: SHA-256 should be {seal['sha256']}, as sealed: {digest}",
            "these are other labels, or they were changed after the cases were made",
        )
    truth: dict[str, Any] = json.loads(data)
    return truth
