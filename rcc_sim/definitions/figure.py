"""A figure: a number, how far it may be off, and where it was taken from."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

Z_90 = 1.6448536269514722  # 1; half-width of a 90 % interval in standard deviations

KEYS = ("value", "sd", "low", "high", "source")


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure of a vehicle file.

    Parameters
    ----------
    value : float
        The number used where one is needed; the middle of a bare range.
    sd : float
        One standard deviation of what it may be wrong by; 0 where not stated.
    low, high : float or None
        Range that the source gives.
    source : str
        Where it is taken from, in words; begins with "guess" if it is one.
    """

    value: float
    sd: float = 0.0
    low: float | None = None
    high: float | None = None
    source: str = ""

    @property
    def interval(self) -> tuple[float, float]:
        """Range as stated, else the 90 % interval of ``sd``, else the value twice."""
        if self.low is not None and self.high is not None:
            return self.low, self.high
        return self.value - Z_90 * self.sd, self.value + Z_90 * self.sd

    @property
    def tolerance(self) -> float:
        """Standard deviation: as stated, or of the range as a 90 % interval, or 0."""
        if self.sd > 0 or self.low is None or self.high is None:
            return self.sd
        return (self.high - self.low) / (2 * Z_90)

    @property
    def is_guess(self) -> bool:
        """Whether the source calls the figure a guess."""
        return self.source.lower().startswith("guess")

    @classmethod
    def parse(cls, raw: Any) -> Figure:
        """Return the figure that a TOML value states: number, range or table.

        Raises
        ------
        ValueError
            If it is none of these, or is not finite, or contradicts itself.
        """
        if isinstance(raw, Figure):
            return raw
        if isinstance(raw, dict):
            return cls._from_table(raw)
        if isinstance(raw, list | tuple):
            if len(raw) != 2:
                raise ValueError("a range should be [low, high]")
            low, high = (_number(part) for part in raw)
            if low > high:
                raise ValueError("a range should run from low to high")
            return cls(value=(low + high) / 2, low=low, high=high)
        return cls(value=_number(raw))

    @classmethod
    def _from_table(cls, raw: dict[str, Any]) -> Figure:
        unknown = set(raw) - set(KEYS)
        if unknown:
            raise ValueError(
                f"no such key in a figure: {', '.join(sorted(unknown))}; "
                f"there are {', '.join(KEYS)}"
            )
        numbers = {k: _number(raw[k]) for k in KEYS[:-1] if k in raw}
        low, high = numbers.get("low"), numbers.get("high")
        if (low is None) != (high is None):
            raise ValueError("low and high should be given together")
        if low is not None and high is not None:
            if low > high:
                raise ValueError("low should not be above high")
            if not low <= numbers.get("value", low) <= high:
                raise ValueError("value should lie between low and high")
            numbers.setdefault("value", (low + high) / 2)
        if "value" not in numbers:
            raise ValueError("a figure needs a value, or low and high")
        if numbers.get("sd", 0.0) < 0:
            raise ValueError("sd should not be negative")
        source = raw.get("source", "")
        if not isinstance(source, str):
            raise ValueError("source should be text")
        return cls(**numbers, source=source)

    @classmethod
    def __get_pydantic_core_schema__(
        cls, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Validate by :meth:`parse`; nothing else is needed of pydantic."""
        return core_schema.no_info_plain_validator_function(cls.parse)


def _number(raw: Any) -> float:
    if isinstance(raw, bool) or not isinstance(raw, int | float):
        kind = {"str": "text", "bool": "true/false", "dict": "a table"}
        found = kind.get(type(raw).__name__, type(raw).__name__)
        raise ValueError(f"should be a number, not {found}")
    if math.isnan(raw):
        raise ValueError("should be a number, not nan")
    return float(raw)
