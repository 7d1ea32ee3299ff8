"""Words that are numbers: blanks, times of the day, dates, a logger's tenths."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from rcc_sim.errors import InputError

Array = NDArray[np.float64]

BLANKS = ["", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "n/a", "null", "NULL", "None"]
BLANKS += ["none", "-", "--", " "]
BLANKS += ["#N/A", "#VALUE!", "#DIV/0!", "#NUM!", "#REF!", "#NAME?", "#NULL!"]
BLANKS += ["#NV", "#WERT!", "#ZAHL!", "#BEZUG!"]
"""What stands where there is no number; a spreadsheet's errors among them."""

DATED = re.compile(
    r"(?P<first>\d{1,2})(?P<mark>[./-])(?P<second>\d{1,2})(?P=mark)(?P<year>\d{4})[ T]+"
    r"(?P<hour>\d{1,2}):(?P<minute>\d\d)(:(?P<rest>\d\d([.,]\d+)?))?"
    r"( ?(?P<half>[AaPp])\.?[Mm]\.?)?"
)
"""A date as a spreadsheet writes it: day or month first, by where it was set up."""


def is_number(word: str, decimal: str = ".") -> bool:
    """Whether a field is a number or blank."""
    word = word.strip()
    if word in BLANKS:
        return True
    try:
        float(word.replace(decimal, "."))
    except ValueError:
        return False
    return True


def clock_seconds(words: Sequence[str], where: str) -> Array:
    """Seconds of the day of ``H:M:S`` words, a decimal comma or point in the last. [s]

    Raises
    ------
    InputError
        Naming the row that is none.
    """

    def seconds(word: str) -> float:
        hours, minutes, rest = word.split(":")
        return 3600 * float(hours) + 60 * float(minutes) + float(rest.replace(",", "."))

    return _numbers(words, where, "a time of day, H:M:S", seconds)


def is_date(word: str) -> bool:
    """Tell whether a word is a date: ISO 8601, or as a spreadsheet writes one."""
    word = word.strip()
    return bool(re.match(r"\d{4}-\d\d-\d\d", word) or DATED.fullmatch(word))


def date_seconds(words: Sequence[str], where: str) -> Array:
    """Seconds since 1970 of dates: ISO 8601, or day and month first. [s]

    One without a zone is UTC. ``24.3.2025`` is a day first; of ``3/24/2025`` that which
    goes beyond 12 tells, in whatever row.

    Raises
    ------
    InputError
        Naming the row that is none; or if no row tells day from month.
    """
    dated = [found for word in words if (found := DATED.fullmatch(word.strip()))]
    month_first = _month_first(dated, where) if dated else False

    def seconds(word: str) -> float:
        found = DATED.fullmatch(word.strip())
        then = _then(found, month_first) if found else datetime.fromisoformat(word)
        return (then if then.tzinfo else then.replace(tzinfo=UTC)).timestamp()

    return _numbers(words, where, "a date, 2025-03-01 12:00:00.25", seconds)


def _month_first(dated: Sequence[re.Match[str]], where: str) -> bool:
    if dated[0]["mark"] == ".":
        return False
    first, second = (max(int(d[k]) for d in dated) for k in ("first", "second"))
    if first <= 12 and second <= 12:
        raise InputError(
            f"{where}: {dated[0][0]!r}: day or month first?",
            "write it as 2025-03-01 12:00:00.25",
        )
    return second > 12


def _then(found: re.Match[str], month_first: bool) -> datetime:
    first, second = int(found["first"]), int(found["second"])
    month, day = (first, second) if month_first else (second, first)
    hour = int(found["hour"])
    if found["half"]:
        hour = hour % 12 + (12 if found["half"] in "pP" else 0)
    rest = float((found["rest"] or "0").replace(",", "."))
    whole = int(rest)
    micro = min(round((rest - whole) * 1e6), 999_999)
    minute = int(found["minute"])
    return datetime(int(found["year"]), month, day, hour, minute, whole, micro)


def carried(words: Sequence[str], where: str) -> Array:
    """Numbers of a logger that writes ten tenths as ".10": 11.10 is 12.0.

    Raises
    ------
    InputError
        Naming the row that is no number.
    """

    def value(word: str) -> float:
        whole, _, tenths = word.strip().partition(".")
        size = abs(float(whole)) + (float(tenths) / 10 if tenths else 0.0)
        return -size if whole.startswith("-") else size

    return _numbers(words, where, "a number", value)


def _numbers(
    words: Sequence[str], where: str, what: str, number_of: Callable[[str], float]
) -> Array:
    """Return the number that each word is, NaN where it is blank."""
    values = np.full(len(words), np.nan)
    for k, word in enumerate(words):
        if word.strip() in BLANKS:
            continue
        try:
            values[k] = number_of(word)
        except ValueError:
            raise InputError(
                f"{where}, row {k + 1}: should be {what}: {word!r}"
            ) from None
    return values
