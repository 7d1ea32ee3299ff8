"""Names for the shell to complete: pass one as ``autocompletion=`` of an argument."""

from __future__ import annotations

from rcc_sim.errors import InputError


def vehicle_names(incomplete: str) -> list[tuple[str, str]]:
    """Return vehicles whose name begins so, with their titles."""
    from rcc_sim.definitions.catalogue import vehicle_rows

    try:
        rows = vehicle_rows()
    except InputError:  # a folder that cannot be listed; the command itself says so
        return []
    return [(r["name"], r["title"]) for r in rows if r["name"].startswith(incomplete)]


def cycle_names(incomplete: str) -> list[tuple[str, str]]:
    """Return cycles whose name begins so, with their titles."""
    from rcc_sim.definitions import library

    try:
        found = library.names("cycles", (".csv", ".csv.gz"))
        about = [library.notes("cycles", entry.path, entry.name) for entry in found]
    except InputError:
        return []
    return [
        (entry.name, str(notes.get("title", "")))
        for entry, notes in zip(found, about, strict=True)
        if entry.name.startswith(incomplete)
    ]


def effect_names(incomplete: str) -> list[tuple[str, str]]:
    """Return effects whose id begins so, with their titles."""
    from rcc_sim.physics.effects import EFFECTS

    return [(n, e.title) for n, e in EFFECTS.items() if n.startswith(incomplete)]
