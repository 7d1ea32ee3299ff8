"""What an effect is: a term of the model that a vehicle may or may not have."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf, isfinite

from rcc_sim.errors import nearest

WIDER = 10.0
"""How far past its typical range a figure without a bound is looked for. [1]"""


OF = (
    *("", "mass", "weight", "wheelbase", "row", "speed", "clock", "motor_speed"),
    *("steering", "motor_current", "braking_current", "braking_torque"),
)
"""What strengths may be stated as shares of: of nothing; the vehicle's mass [kg], its
weight [N] or wheelbase [m]; the time between two rows, that by which a speed must be
late to be told, or that between two orders that a log can tell apart [s]; the highest
motor speed [rad/s], the largest angle of the wheels [rad], current [A], current or
torque of braking [A, N m] of the drive."""

ACTS = ("", "steps", "clock", "rows", "slip")
"""How a model changes as a figure moves: smoothly; all at once, where a command passes
a threshold; with no slope at all, as with a period; by whole rows of a log; as a tyre's
slip, by which the wheels are ahead in time."""

DRIVES = (
    *("commanded", "imposed", "speed_loop", "throttle"),
    *("steered", "turning", "unsurveyed", "metered"),
)
"""What a drive may have to be for an effect to show: driven by a controller, or as it
was measured; controlled by speed, or by throttle; with steering; with a yaw rate that
the model finds itself; on a road whose slope no log tells; with its auxiliary power
logged."""


@dataclass(frozen=True, slots=True)
class Sought:
    """How a diagnosis looks for a figure.

    Where nothing is stated, along its slope, from a typical strength on.

    Parameters
    ----------
    tried : tuple of float
        Strengths that are all tried: those of thresholds, limits, delays and clocks.
    limits : tuple of float or None
        Least and most that is looked for, where that is less than the bounds.
    of : str
        What these are shares of, one of ``OF``.
    longest : float
        Largest strength that is tried, whatever it is a share of.
    acts : str
        How the model changes as it moves, one of ``ACTS``.
    same_as : str
        Figure of a vehicle file that it adds to, or multiplies where 1 is neutral.
    shows_in : tuple of str
        What a drive must be for it to show, of ``DRIVES``.
    columns : tuple of str
        Columns of a log of which one at least must be there for it to show.
    opposes : tuple of str
        Parameters of the same effect that undo it, and are not found beside it.
    fitted : bool
        Whether it is looked for at all; else it stands beside another.
    """

    tried: tuple[float, ...] = ()
    limits: tuple[float, float] | None = None
    of: str = ""
    longest: float = inf
    acts: str = ""
    same_as: str = ""
    shows_in: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    opposes: tuple[str, ...] = ()
    fitted: bool = True


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
    sought : Sought
        How a diagnosis looks for it.
    """

    name: str
    neutral: float
    bounds: tuple[float, float] = (0.0, inf)
    typical: tuple[float, float] = (0.0, 0.0)
    about: str = ""
    optional: bool = False
    sought: Sought = Sought()

    @property
    def is_factor(self) -> bool:
        """Whether it multiplies a figure of the vehicle file."""
        return bool(self.sought.same_as) and self.neutral == 1.0

    @property
    def acts(self) -> str:
        """How the model changes as it moves: one of ``ACTS``, or as a factor.

        A limit of which nothing else is said may be a threshold.
        """
        if self.neutral == inf and self.sought == Sought():
            return "steps"
        return self.sought.acts or "factor" * self.is_factor

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
    needs_any : tuple of str
        Keys of which it needs one at least.
    excludes : tuple of str
        Effects that it stands in place of: a file that states both is an error.
    files : tuple of str
        Parameters that name a file in place of a number.
    sensor : bool
        Whether it touches the log alone: its file then holds ``sensed(columns, time,
        *values)``, which returns the columns that change.
    shows_in : tuple of str
        What a drive must be for it to show, of ``DRIVES``.
    sums : tuple of str
        Effects whose sum it is, if it is one: no cause unless a file states it.
    rare : bool
        Whether some vehicles alone have it: no cause unless it is asked for.
    left_as : tuple of str
        How what such a one leaves acts, and the column that it follows.
    either : bool
        Whether its parameters are alternatives: a file that states one has no other.
    also : tuple of str
        Other words for it, by which somebody may ask for it.
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
    needs_any: tuple[str, ...] = ()
    excludes: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    sensor: bool = False
    shows_in: tuple[str, ...] = ()
    sums: tuple[str, ...] = ()
    rare: bool = False
    left_as: tuple[str, str] = ("", "")
    either: bool = False
    also: tuple[str, ...] = ()

    @property
    def neutral(self) -> dict[str, float]:
        """Parameter name -> the value at which the effect vanishes."""
        return {param.name: param.neutral for param in self.params}

    def param(self, name: str) -> Param:
        """Return the parameter of that name."""
        return next(param for param in self.params if param.name == name)


def meant(name: str, known: Mapping[str, Effect], others: Iterable[str] = ()) -> str:
    """Return a hint for an effect that is not known: those with such words, or near.

    Of some ``others`` the name alone is known.
    """
    asked = words_of(name)
    having = [
        one.id
        for one in known.values()
        if asked
        and any(asked <= words_of(said) for said in (one.id, one.title, *one.also))
    ]
    if len(having) > 1:
        return f"did you mean one of {', '.join(having)}?"
    if having:
        return f"did you mean `{having[0]}`?"
    near = nearest(name, [*known, *others])
    return f"did you mean `{near}`?" if near else "`rccsim effects` lists them"


def words_of(said: str) -> set[str]:
    """Return the words of a name or a phrase."""
    return set(said.lower().replace("_", " ").split())
