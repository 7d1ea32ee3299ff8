"""The energy of each log: does what was found mend it, or open a gap?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from rcc_sim.analyse.gap import Gap
from rcc_sim.analyse.gap_energy import COVERAGE
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.judge.energies import grew
from rcc_sim.diagnose.proof.hold_out import driven_by, energy_by_log


@dataclass(frozen=True)
class LogEnergy:
    """Energy gap of one log, by the file's vehicle and by the mended one.

    Parameters
    ----------
    log : str
        Its name.
    before, after : float or None
        Of the log's energy; None where the log tells none. [%]
    chance : float
        What noise and a rough road may put it off by. [%]
    """

    log: str
    before: float | None
    after: float | None
    chance: float

    @property
    def disagrees(self) -> bool:
        """Whether what was found makes its gap larger, beyond chance."""
        if self.before is None or self.after is None:
            return False
        return grew(self.before, self.after) and abs(self.after) > self.chance


def each_log(
    gaps: Sequence[Gap], nominal: Engine, acting: Engine, fit: Fit, *, by_torque: bool
) -> tuple[LogEnergy, ...]:
    """Return the energy gap of each log, before and after."""
    before, after = (
        energy_by_log(driven_by(engine.problems, by_torque=by_torque), values)
        for engine, values in ((nominal, {}), (acting, fit.values))
    )
    return tuple(
        LogEnergy(gap.log, was, left, noise_of([gap]))
        for gap, was, left in zip(gaps, before, after, strict=True)
    )


def noise_of(gaps: Sequence[Gap]) -> float:
    """Return how far noise and a rough road may put the energy of logs, in percent.

    The mean of the sizes of their gaps, in percent of all their energy.
    """
    measured = abs(sum(g.energy.measured_wh or 0.0 for g in gaps))
    noise = sum(g.energy.noise_wh for g in gaps)
    return 100 * COVERAGE * noise / measured if measured else inf
