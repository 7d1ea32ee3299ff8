"""Where vehicles and cycles are found: one search order for both kinds.

A name is looked for in the working folder's ``vehicles/`` or ``cycles/``, in the
user's own folder, in the folders of installed plugins, and among those shipped; the
first that has it wins. A path is taken as it is. Nothing is ever put in the place of
a name that is not there.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from rcc_sim.errors import InputError

HOME_VARIABLE = "RCCSIM_HOME"
"""Environment variable that names the user's own folder in place of the default."""

TITLE = re.compile(r'^title *= *"(.*)"', re.MULTILINE)

KINDS = "vehicles", "cycles"
"""What is kept in folders of these names."""

PACKAGE = Path(__file__).resolve().parents[1]


class Place(NamedTuple):
    """A folder that is searched, or a file that was found, and whose it is.

    Attributes
    ----------
    path : Path
        The folder or file.
    origin : str
        "path", "working folder", "user folder", "plugin NAME" or "shipped".
    """

    path: Path
    origin: str


class Entry(NamedTuple):
    """One definition of a listing.

    Attributes
    ----------
    name : str
        What commands call it: the file's name without its suffix.
    path : Path
        The file.
    origin : str
        As in `Place`.
    shadows : tuple of str
        Origins of the files of the same name that this one hides.
    """

    name: str
    path: Path
    origin: str
    shadows: tuple[str, ...]


def folders(kind: str) -> list[Place]:
    """Folders of a kind ("vehicles" or "cycles") that exist, in the order of search."""
    return list(_folders(kind))


def find(
    kind: str,
    name: str,
    suffixes: tuple[str, ...],
    places: Sequence[Place] | None = None,
) -> Place:
    """File of a definition, from its name or its path.

    Parameters
    ----------
    kind : str
        "vehicles" or "cycles".
    name : str
        A name, or a path: what holds a path separator or ends in one of `suffixes`.
    suffixes : tuple of str
        Endings of the files of this kind, dot included.
    places : sequence of Place, optional
        Folders to search; those of `folders` unless given. Plugins are asked only if
        the folders before them do not have the name.

    Returns
    -------
    place : Place
        The file, and whose it is.

    Raises
    ------
    InputError
        If there is no such file or name; the hint lists close names and all there are.
    """
    if is_path(name, suffixes):
        return Place(_existing(Path(name).expanduser()), "path")
    for folder in _folders(kind) if places is None else places:
        for suffix in suffixes:
            path = folder.path / (name + suffix)
            if path.is_file():
                return Place(path, folder.origin)
    raise _unknown(kind, name, names(kind, suffixes, places))


def names(
    kind: str, suffixes: tuple[str, ...], places: Sequence[Place] | None = None
) -> list[Entry]:
    """Every definition of a kind, by name, and what it hides.

    Parameters
    ----------
    kind, suffixes, places
        As in `find`.

    Returns
    -------
    entries : list of Entry
        One for each name, sorted; the first place in the order of search wins.
    """
    found: dict[str, list[Place]] = {}
    for folder in folders(kind) if places is None else places:
        for path in _files(folder.path):
            suffix = next((s for s in suffixes if path.name.endswith(s)), "")
            if suffix and not path.name.startswith("."):
                name = path.name.removesuffix(suffix)
                found.setdefault(name, []).append(Place(path, folder.origin))
    return [
        Entry(name, hits[0].path, hits[0].origin, tuple(hit.origin for hit in hits[1:]))
        for name, hits in sorted(found.items())
    ]


def named_by(vehicle: Path | None, name: str) -> Path:
    """File that a vehicle's file names: a map of efficiency, a road.

    It counts from the folder of the vehicle's file. A bare name that is not there is
    looked for where vehicles are, so that a copy of a vehicle finds what the vehicle
    came with.

    Parameters
    ----------
    vehicle : Path or None
        The vehicle's file; the working folder counts where it has none.
    name : str
        As stated.

    Returns
    -------
    path : Path
        Where it is, or, if it is nowhere, where it should be.
    """
    stated = Path(name).expanduser()
    beside = (vehicle.parent if vehicle else Path()) / stated
    if beside.exists() or stated.name != name:
        return beside
    places = (place.path / name for place in _folders("vehicles"))
    return next((path for path in places if path.is_file()), beside)


def is_everywhere(path: Path) -> bool:
    """Whether a vehicle anywhere finds a file by its bare name (`named_by`)."""
    for place in _folders("vehicles"):
        if place.origin != "working folder" and (place.path / path.name).is_file():
            return (place.path / path.name).resolve() == path.resolve()
    return False


def is_path(name: str, suffixes: tuple[str, ...]) -> bool:
    """Whether a user's words are a path: a separator in them, or a known suffix."""
    separators = [s for s in (os.sep, os.altsep) if s]
    return any(s in name for s in separators) or name.endswith(suffixes)


def notes(kind: str, path: Path, name: str) -> dict[str, str | float]:
    """What the folder's own ``KIND.toml`` says of a file: title, source, licence.

    Parameters
    ----------
    kind : str
        "vehicles" or "cycles"; ``cycles.toml`` lies beside the cycles it describes.
    path : Path
        The definition's file.
    name : str
        Its name, which is the table's name.

    Returns
    -------
    table : dict
        The table's keys; empty if the folder says nothing of this file.

    Raises
    ------
    InputError
        If there is such a file and it is not sound TOML.
    """
    about = path.parent / f"{kind}.toml"
    if not about.is_file():
        return {}
    try:
        tables = tomllib.loads(about.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{about}: should be a TOML file: {error}") from error
    table = tables.get(name, {})
    if not isinstance(table, dict):
        raise InputError(f"{about}: {name}: should be a table: {table!r}")
    return table


def _folders(kind: str) -> Iterator[Place]:
    """The places of `folders`, one by one, so that plugins are asked last-minute."""
    if kind not in KINDS:
        raise ValueError(f"no such kind of definition: {kind}")
    shipped = _shipped(kind)
    seen: set[Path] = set()
    for place in _candidates(kind, shipped):
        resolved = place.path.resolve()
        if resolved not in seen and resolved.is_dir():
            seen.add(resolved)
            is_shipped = resolved == shipped.resolve()
            yield Place(place.path, "shipped") if is_shipped else place


def _candidates(kind: str, shipped: Path) -> Iterator[Place]:
    yield Place(Path(kind), "working folder")
    yield Place(_user_folder() / kind, "user folder")
    yield from _plugins(kind)
    yield Place(shipped, "shipped")


def _shipped(kind: str) -> Path:
    """The folder in the wheel, or else in the checkout that the package lies in."""
    in_wheel = PACKAGE / "_shipped"
    return (in_wheel if in_wheel.is_dir() else PACKAGE.parent) / kind


def _user_folder() -> Path:
    home = os.environ.get(HOME_VARIABLE)
    if home:
        return Path(home).expanduser()
    from platformdirs import user_data_dir

    return Path(user_data_dir("rccsim", appauthor=False))


def _plugins(kind: str) -> Iterator[Place]:
    """Folders of the entry points ``rccsim.KIND``, without importing any of them."""
    from importlib.metadata import entry_points

    group = f"rccsim.{kind}"
    for point in sorted(entry_points(group=group), key=lambda p: (p.name, p.value)):
        for folder in _module_folders(point.module, f"plugin {point.name}"):
            yield Place(folder, f"plugin {point.name}")


def _module_folders(module: str, who: str) -> list[Path]:
    """Folders of a package, or the folder that a module lies in; nothing is run."""
    from importlib.util import find_spec

    top, *inner = module.split(".")
    spec = find_spec(top)
    if spec is not None and spec.submodule_search_locations is not None:
        roots = [
            Path(place).joinpath(*inner) for place in spec.submodule_search_locations
        ]
        packages = [root for root in roots if root.is_dir()]
        modules = [root.parent for root in roots if root.with_suffix(".py").is_file()]
        if packages or modules:
            return packages or modules
    elif spec is not None and spec.origin is not None and not inner:
        return [Path(spec.origin).parent]
    raise InputError(
        f"{who}: should name an installed module or package: {module}",
        "reinstall the plugin's package, or uninstall it",
    )


def _files(folder: Path) -> list[Path]:
    try:
        return sorted(path for path in folder.iterdir() if path.is_file())
    except OSError as error:
        raise InputError(f"{folder}: cannot be listed: {error.strerror}") from error


def _existing(path: Path) -> Path:
    if path.is_dir():
        raise InputError(f"{path}: should be a file: it is a folder")
    if not path.exists():
        from difflib import get_close_matches
        from glob import escape

        beside = [p.name for p in path.parent.glob(f"*{escape(path.suffix)}")]
        ended = sorted(n for n in beside if n.startswith(f"{path.name}."))
        close = ended or get_close_matches(path.name, beside, n=1)
        near = [path.with_name(name) for name in close]
        if path.parent == Path() and not near:
            near = [p for p in (Path(kind, path.name) for kind in KINDS) if p.is_file()]
        mean = f"did you mean `{near[0]}`?" if near else ""
        raise InputError(f"{path}: no such file", mean)
    return path


def _parts(name: str) -> set[str]:
    """Return the words of a name: r1t and epa of r1t_epa."""
    return set(re.split(r"[\W_]+", name.lower())) - {""}


def _called(entry: Entry) -> set[str]:
    """Return the words of a definition's name, and of its title if it has one."""
    try:
        text = entry.path.read_text("utf-8")
    except (OSError, UnicodeDecodeError):
        text = ""
    title = TITLE.search(text)
    return _parts(entry.name) | _parts(title[1] if title else "")


def _unknown(kind: str, name: str, entries: list[Entry]) -> InputError:
    """The error for a name that no place has."""
    from difflib import get_close_matches

    known = [entry.name for entry in entries]
    asked = name.lower()
    close = get_close_matches(asked, known, n=3, cutoff=0.6)
    close = close or [e.name for e in entries if _called(e) & _parts(asked)]
    like = f"did you mean {' or '.join(f'`{c}`' for c in close)}? " if close else ""
    there = f"there are {', '.join(known)}" if known else "none was found in any folder"
    hint = f"{like}{there}; a path to a file serves too"
    what = kind.removesuffix("s")
    here = Path(name).expanduser()
    if here.is_dir():
        return InputError(f"{name}: is a folder, and no {what} is called so", hint)
    if here.is_file():
        return InputError(f"{name}: is no {what} file by its ending", hint)
    return InputError(f"no such {what}: {name!r}", hint)
