"""A cause: an effect that is asserted, and by how much it gained."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.profile import Profile, overlap

Array = NDArray[np.float64]

ENOUGH = 18.0
"""Nats that a cause must gain, by the noise before and after it alike.

Of 200 drives of the blind plant without a cause, 4 had a candidate that gained more,
all over the log (`rccsim blind make --kinds null --cases 200 --seed 9001`).
"""

TIED = 3.0
"""Nats below which two candidates cannot be told apart: odds of 20 to 1 (Jeffreys'
"strong" begins there)."""

ANOTHER_VEHICLE = 10.0
"""Standard deviations from which on a stated figure is that of another vehicle, or all
together are. Of 240 drives of the blind plant none with a cause has one, of 450 one; in
these all together are 5 at most otherwise."""

PROFILES = {
    "road_grade": ("effects.road_grade.slope", "distance_m"),
    "auxiliary_load": ("effects.auxiliary_load.power_w", "time_s"),
    "headwind": ("effects.headwind.speed_mps", "time_s"),
}
"""Effect that may vary -> its figure, and what it varies along."""

DRAGS = frozenset(
    (
        *("rolling_resistance", "aerodynamic_drag", "road_load", "road_grade"),
        *("drivetrain_friction", "drivetrain_damping", "iron_loss", "gear_loss"),
        *("headwind", "friction_brake"),
    )
)
"""Effects that hold a vehicle back, and may hold part of what does so besides."""

PROFILE_ENOUGH, BRISK_ENOUGH = 60.0, 30.0
"""Nats that a profile must gain; and a load that changes within twice the time that
noise remembers, which nothing that is slow by chance looks like, or that hangs together
and is weighed against the noise that passes for it. Of 264 drives of the blind plant
without a cause, 6 had a slope that gained 46 to 69 (a rough road is a force, too), none
a load that gained more than 26, and none of the 140 short ones a load that gained 1; of
110 others none had a load that hangs together in as many windows as are tried first. It
must beat a constant by half of this. One that is weighed together with a sensor's drift
needs no more than a constant cause: noise alone gained 10 once in 100 draws."""

LEAVES = 0.03
"""Share of a cause's nats, by the noise that it leaves, that it may leave in its own
tracks where its model is not exact: of 201 drives of the blind plant no cause that
acted left more."""

WIND_ENOUGH = 90.0
"""Nats that gusts must gain. Of 80 drives of the blind plant without a cause (`rccsim
blind make --kinds null --family ev --cases 80 --seed 4201`) one had a wind, that gained
68."""


@dataclass(frozen=True)
class Cause:
    """An effect that is asserted.

    Parameters
    ----------
    effect : str
        Its id.
    keys : tuple of str
        Dotted keys of the figures found.
    gain : float
        Nats it gained when it was taken in.
    eased : float
        Nats of that by which stated figures went back with it.
    rival : float
        Nats of the best candidate that is not tied with it.
    tied : tuple of str
        Effects that these logs cannot tell from it.
    profiles : dict
        Log -> profile, where it varies over the drive.
    sharpened : float
        Times more that it gained by the noise it leaves than by ``gain``.
    shares : ndarray
        Share of each track in what it changes.
    screened : dict
        Effect -> nats that it gained when this one was found, or to first order would
        have gained in its place.
    cut : dict
        Log -> what its profile would have to be beyond what is possible: left
        unexplained.
    cut_nats : float
        Nats that were given up with that.
    """

    effect: str
    keys: tuple[str, ...]
    gain: float
    eased: float = 0.0
    rival: float = 0.0
    tied: tuple[str, ...] = ()
    profiles: dict[int, Profile] = field(default_factory=dict)
    sharpened: float = 1.0
    shares: Array = field(default_factory=lambda: np.zeros(0))
    screened: dict[str, float] = field(default_factory=dict)
    cut: dict[int, Profile] = field(default_factory=dict)
    cut_nats: float = 0.0

    @property
    def sharp(self) -> float:
        """Nats that it gained by the noise that it leaves."""
        return self.gain * self.sharpened

    @property
    def trusted(self) -> float:
        """Those nats, and once more those by which stated figures went back."""
        return self.sharp + self.eased

    @property
    def over_time(self) -> bool:
        """Whether it varies with the time, and not along the road."""
        return any(p.along == "time_s" for p in self.profiles.values())

    @property
    def along_way(self) -> bool:
        """Whether it varies with the place: as a hill, which is the road's."""
        return any(p.along == "distance_m" for p in self.profiles.values())

    @property
    def weighed(self) -> bool:
        """Whether it varies, and was weighed together with the noise that it leaves."""
        return any(p.weighed for p in self.profiles.values())


def left_by_stronger(cause: Cause, causes: Iterable[Cause]) -> float:
    """Return the nats that stronger causes may leave in the tracks of a cause."""
    return max(
        (
            LEAVES * c.sharp * overlap(c.shares, cause.shares)
            for c in causes
            if c.sharp > cause.sharp
        ),
        default=0.0,
    )
