"""What an effect is: a term of the model that a vehicle may or may not have."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite

WIDER = 10.0
"""How far past its typical range a figure without a bound is looked for. [1]"""


@dataclass(frozen=True, slots=True)
class Param:
    """One parameter of an effect.

    Parameters
    ----------
    name : str
        Edge name, the unit as its last part.
    neutral : float
        Value at which the effect vanishes bit-identically.
    bounds : tuple of float
        Smallest and largest value with a meaning.
    typical : tuple of float
        Where it usually lies, for small cars and for road vehicles alike.
    about : str
        What it is, in words.
    optional : bool
        Whether a vehicle file may leave it out (it then keeps its neutral value).
    """

    name: str
    neutral: float
    bounds: tuple[float, float] = (0.0, inf)
    typical: tuple[float, float] = (0.0, 0.0)
    about: str = ""
    optional: bool = False

    @property
    def search(self) -> tuple[float, float]:
        """Finite range in which a fit may look: the bounds, or WIDER than typical.

        Where a bound is infinite, as that of a limit which is absent at infinity, the
        typical range times or over WIDER stands in its place.
        """
        low, high = self.bounds
        return (
            low if isfinite(low) else self.typical[0] - WIDER * abs(self.typical[0]),
            high if isfinite(high) else WIDER * self.typical[1],
        )


@dataclass(frozen=True, slots=True)
class Effect:
    """A switchable term of the one model.

    Parameters
    ----------
    id : str
        Name in files and on the command line.
    title, equation, seen_as, source : str
        What it is, its formula, how a log shows it, where it is taken from.
    params : tuple of Param
        Its parameters.
    channels : tuple of str
        Columns that show it first.
    sink : str
        Ledger line that it owns; empty where it moves energy but keeps none.
    needs : tuple of str
        Keys of the vehicle file without which it cannot be computed.
    excludes : tuple of str
        Effects that it stands in place of: a file that states both is an error.
    files : tuple of str
        Parameters that name a file in place of a number.
    sensor : bool
        Whether it touches the log alone: its file then holds ``sensed(columns, time,
        *values)``, which returns the columns that change.
    """

    id: str
    title: str
    equation: str
    params: tuple[Param, ...]
    channels: tuple[str, ...]
    seen_as: str
    source: str
    sink: str = ""
    needs: tuple[str, ...] = ()
    excludes: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    sensor: bool = False

    @property
    def neutral(self) -> dict[str, float]:
        """Parameter name -> the value at which the effect vanishes."""
        return {param.name: param.neutral for param in self.params}

    def param(self, name: str) -> Param:
        """Return the parameter of that name."""
        return next(param for param in self.params if param.name == name)
