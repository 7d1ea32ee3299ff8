"""Column maps: what a file calls a channel, and in what unit, as TOML."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from rcc_sim.errors import InputError, did_you_mean, nearest_first
from rcc_sim.readers.names import refuse_unfinished, unread
from rcc_sim.units import G, unit_of

FOLDER = Path(__file__).with_name("maps")
CLOCK, DATE = "h:m:s", "date"

UNITS: dict[str, tuple[float, str]] = {
    "s": (1.0, "s"),
    "ms": (1e-3, "s"),
    "us": (1e-6, "s"),
    "ns": (1e-9, "s"),
    "min": (60.0, "s"),
    CLOCK: (1.0, "s"),
    DATE: (1.0, "s"),
    "m/s": (1.0, "m/s"),
    "km/h": (1 / 3.6, "m/s"),
    "mph": (0.44704, "m/s"),
    "m/s^2": (1.0, "m/s²"),
    "g": (G, "m/s²"),
    "mg": (G / 1000, "m/s²"),
    "rad": (1.0, "rad"),
    "deg": (math.pi / 180, "rad"),
    "rad/s": (1.0, "rad/s"),
    "deg/s": (math.pi / 180, "rad/s"),
    "rpm": (2 * math.pi / 60, "rad/s"),
    "rev/s": (2 * math.pi, "rad/s"),
    "m": (1.0, "m"),
    "km": (1000.0, "m"),
    "cm": (0.01, "m"),
    "mm": (0.001, "m"),
    "N m": (1.0, "N m"),
    "V": (1.0, "V"),
    "mV": (1e-3, "V"),
    "A": (1.0, "A"),
    "mA": (1e-3, "A"),
    "W": (1.0, "W"),
    "kW": (1000.0, "W"),
    "degC": (1.0, "°C"),
    "%": (0.01, "1"),
    "percent": (1.0, "%"),
}
"""Unit that a map may name -> factor to ours, and ours."""

TERM_KEYS = {
    "from", "unit", "factor", "sign", "offset", "times", "wrap_s", "missing",
    "absent", "below", "blank_where", "negative_where", "guess", "optional",
}  # fmt: skip
MAP_KEYS = {
    "title", "source", "format", "header", "separator", "encoding", "decimal",
    "skip_rows", "rate_hz", "carry_tenths", "notes",
}  # fmt: skip
ALIKE = 0.6
"""Share of a map's header from which on a file that lacks some of it is like it."""

SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": " "}


@dataclass(frozen=True)
class Where:
    """Rows that another column picks: those where it is `equals`."""

    source: str
    equals: str


@dataclass(frozen=True)
class Term:
    """One source column turned into our unit.

    ours = sign · factor · (theirs in our unit) + offset

    Parameters
    ----------
    sources : tuple of str
        Names in the file; the first that is there is taken.
    unit : str
        Theirs; empty if it is ours.
    scale, offset : float
        Sign, factor and unit together; and the offset. [our unit]
    times : str
        Another column that it is multiplied by.
    wrap_s : float
        The clock starts over after this. [s]
    missing : tuple of float
        Values that mean "none" in their row.
    absent, below : float
        The column means nothing if it is this, or below this, all along.
    blank_where, negative_where : Where or None
        Rows without a value, and rows whose sign turns.
    guess : str
        What the map assumes and the file does not say.
    optional : bool
        A file that lacks it goes without the column; else that is an error.
    """

    sources: tuple[str, ...]
    unit: str = ""
    scale: float = 1.0
    offset: float = 0.0
    times: str = ""
    wrap_s: float = math.inf
    missing: tuple[float, ...] = ()
    absent: float = math.nan
    below: float = -math.inf
    blank_where: Where | None = None
    negative_where: Where | None = None
    guess: str = ""
    optional: bool = False


@dataclass(frozen=True)
class ColumnMap:
    """How the columns of a kind of file become ours.

    Parameters
    ----------
    name, where : str
        The file's stem, and its path for errors.
    title, origin : str
        What it is for, and where that is known from.
    shipped : bool
        Whether it came with a package; then all of its columns are optional.
    format : str
        "csv", "bag", "mf4" or "parquet".
    header : tuple of str
        Names that a file must have to be recognised.
    separator, encoding, decimal : str
        Of a CSV file; found unless given.
    skip_rows : int
        Lines above the header.
    rate_hz : float
        Rows a second of a file without a clock. [Hz]
    carry_tenths : bool
        Whether ".10" is a carry: 11.10 is 12.0.
    notes : tuple of str
        What a person should know of such a file.
    columns : dict
        Our name -> the terms that add up to it.
    """

    name: str
    where: str
    shipped: bool
    title: str = ""
    origin: str = ""
    format: str = "csv"
    header: tuple[str, ...] = ()
    separator: str = ""
    encoding: str = ""
    decimal: str = ""
    skip_rows: int = 0
    rate_hz: float = 0.0
    carry_tenths: bool = False
    notes: tuple[str, ...] = ()
    columns: Mapping[str, tuple[Term, ...]] = field(default_factory=dict)

    def wanted(self) -> list[str]:
        """Names that any of the columns may need."""
        found: dict[str, None] = {}
        for term in (term for terms in self.columns.values() for term in terms):
            rows = (term.blank_where, term.negative_where)
            also = [term.times, *(where.source for where in rows if where)]
            found |= dict.fromkeys([*term.sources, *filter(None, also)])
        return list(found)


def load_map(name: str | Path) -> ColumnMap:
    """Column map of a TOML file, or of the name of a shipped one.

    Raises
    ------
    InputError
        If there is none, or naming file, key and what is wrong with it.
    """
    shipped = {m.name: m for m in shipped_maps()}
    if str(name) in shipped:
        return shipped[str(name)]
    path = Path(name).expanduser()
    if not path.is_file():
        rest = f"a TOML file, or one of {', '.join(sorted(shipped))}"
        hint = nearest_first(str(name), list(shipped), rest)
        raise InputError(f"{name}: no such column map", hint)
    return _load(path, shipped=False)


@cache
def shipped_maps() -> tuple[ColumnMap, ...]:
    """Column maps that come with rccsim, by name."""
    return tuple(_load(path, shipped=True) for path in sorted(FOLDER.glob("*.toml")))


def matching(maps: Sequence[ColumnMap], names: Sequence[str]) -> ColumnMap | None:
    """The map whose whole header is among the names: the longest one, or None."""
    there = set(names)
    fit = [m for m in maps if m.header and there.issuperset(m.header)]
    return max(fit, key=lambda m: len(m.header), default=None)


def nearest(maps: Sequence[ColumnMap], names: Sequence[str]) -> ColumnMap | None:
    """The map of whose header most is among the names, if that is ``ALIKE`` of it."""
    there = set(names)
    share = {m.name: len(there & set(m.header)) / max(len(m.header), 1) for m in maps}
    best = max(maps, key=lambda m: share[m.name], default=None)
    return best if best and share[best.name] >= ALIKE else None


def _load(path: Path, *, shipped: bool) -> ColumnMap:
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: should be a TOML file: {error}") from None
    return map_of(text, path, shipped=shipped)


def map_of(text: str, path: Path, *, shipped: bool = False) -> ColumnMap:
    """Return the column map that a TOML text holds; ``path`` is for errors and name.

    Raises
    ------
    InputError
        Naming file, key and what is wrong with it.
    """
    where = str(path)
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{where}: should be a TOML file: {error}") from None
    _known(raw, {"map", "columns"}, where)
    head, columns = _table(raw, "map", where), _table(raw, "columns", where)
    _known(head, MAP_KEYS, f"{where}: map")
    if not columns:
        raise InputError(
            f"{where}: columns: missing", 'as in: speed_mps = { from = "Speed" }'
        )
    separator = str(head.get("separator", ""))
    return ColumnMap(
        name=path.stem,
        where=where,
        shipped=shipped,
        title=str(head.get("title", "")),
        origin=str(head.get("source", "")),
        format=str(head.get("format", "csv")),
        header=tuple(head.get("header", ())),
        separator=SEPARATORS.get(separator, separator),
        encoding=_encoding(str(head.get("encoding", "")), where),
        decimal=str(head.get("decimal", "")),
        skip_rows=int(_number(head, "skip_rows", 0, where)),
        rate_hz=_number(head, "rate_hz", 0.0, where),
        carry_tenths=_yes(head, "carry_tenths", f"{where}: map"),
        notes=(*head.get("notes", ()), *(() if shipped else unread(columns))),
        columns={n: _terms(n, c, where) for n, c in columns.items()},
    )


def _terms(column: str, raw: Any, where: str) -> tuple[Term, ...]:
    key = f"{where}: columns.{column}"
    if not re.fullmatch(r"[a-z][a-z0-9_]*", column):
        raise InputError(f"{key}: should be lower_snake_case with its unit last")
    refuse_unfinished(column, key)
    if isinstance(raw, str):
        raw = {"from": raw}
    if not isinstance(raw, dict):
        raise InputError(f"{key}: should be a table or a name: {raw!r}")
    if "sum" not in raw:
        return (_term(column, raw, key),)
    _known(raw, {"sum"}, key)
    return tuple(_term(column, part, f"{key}.sum") for part in raw["sum"])


def _term(column: str, raw: dict[str, Any], key: str) -> Term:
    _known(raw, TERM_KEYS, key)
    names = raw.get("from")
    sources = (names,) if isinstance(names, str) else tuple(names or ())
    if not sources or not all(isinstance(name, str) for name in sources):
        raise InputError(f"{key}.from: should be the column's name in the file")
    unit = str(raw.get("unit", ""))
    scale = _unit_scale(column, unit, key) * _number(raw, "factor", 1.0, key)
    sign = _number(raw, "sign", 1.0, key)
    if sign not in (-1.0, 1.0):
        raise InputError(f"{key}.sign: should be 1 or -1: {sign:g}")
    missing = raw.get("missing", ())
    missing = missing if isinstance(missing, list | tuple) else (missing,)
    return Term(
        sources=sources,
        unit=unit,
        scale=sign * scale,
        offset=_number(raw, "offset", 0.0, key),
        times=str(raw.get("times", "")),
        wrap_s=_number(raw, "wrap_s", math.inf, key),
        missing=tuple(_number({"missing": v}, "missing", 0.0, key) for v in missing),
        absent=_number(raw, "absent", math.nan, key),
        below=_number(raw, "below", -math.inf, key),
        blank_where=_where(raw, "blank_where", key),
        negative_where=_where(raw, "negative_where", key),
        guess=str(raw.get("guess", "")),
        optional=_yes(raw, "optional", key),
    )


def _plain(unit: str) -> str:
    """Return a unit by its letters and figures alone."""
    return re.sub(r"[^0-9a-z%]", "", unit.lower())


def _unit_scale(column: str, unit: str, key: str) -> float:
    ours = unit_of(column)
    if not unit:
        return 1.0
    if unit not in UNITS:
        same = [known for known in UNITS if _plain(known) == _plain(unit)]
        rest = f"there are {', '.join(UNITS)}; or give a factor"
        raise InputError(
            f"{key}.unit: not a unit that is known: {unit!r}",
            nearest_first(same[0] if same else unit, list(UNITS), rest),
        )
    factor, to = UNITS[unit]
    if to != ours:
        own = f"a column of {unit}" if ours == "1" else f"{column} is in {ours}"
        raise InputError(
            f"{key}.unit: {unit} cannot become {ours}",
            f"{own}: a name ends in its unit, as speed_mps, or in none",
        )
    return factor


def _where(raw: dict[str, Any], name: str, key: str) -> Where | None:
    if name not in raw:
        return None
    table = raw[name]
    if not isinstance(table, dict) or table.keys() != {"from", "equals"}:
        raise InputError(f'{key}.{name}: should be {{ from = "NAME", equals = VALUE }}')
    return Where(str(table["from"]), str(table["equals"]))


def _table(raw: dict[str, Any], name: str, where: str) -> dict[str, Any]:
    found = raw.get(name, {})
    if not isinstance(found, dict):
        raise InputError(f"{where}: {name}: should be a table, [{name}]")
    return found


def _number(raw: Mapping[str, Any], name: str, default: float, key: str) -> float:
    value = raw.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{key}.{name}: should be a number: {value!r}")
    return float(value)


def _yes(raw: Mapping[str, Any], name: str, key: str) -> bool:
    value = raw.get(name, False)
    if not isinstance(value, bool):
        raise InputError(f"{key}.{name}: should be true or false: {value!r}")
    return value


def _known(raw: Mapping[str, Any], keys: set[str], where: str) -> None:
    for key in raw:
        if key not in keys:
            hint = did_you_mean(key, sorted(keys))
            raise InputError(f"{where}: {key}: no such key", hint)


def _encoding(name: str, where: str) -> str:
    import codecs

    try:
        return codecs.lookup(name).name if name else ""
    except LookupError:
        raise InputError(f"{where}: map.encoding: unknown: {name!r}") from None
