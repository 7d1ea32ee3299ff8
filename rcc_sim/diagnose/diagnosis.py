"""What a diagnosis found: as JSON, as figures of a mended file, as prices."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from math import inf
from typing import Any

from rcc_sim.analyse.gap import Gap
from rcc_sim.analyse.gap_report import where
from rcc_sim.definitions.figure import Z_90, Figure
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.causes.cause import ANOTHER_VEHICLE
from rcc_sim.diagnose.causes.prices import Prices, prices
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import BIAS, OWN, RADIUS, Knob
from rcc_sim.diagnose.fitting.pulls import farthest, moved, moved_together
from rcc_sim.diagnose.judge.asserted import INTERVAL, Asserted
from rcc_sim.diagnose.judge.energies import SHRUNK, stays_off
from rcc_sim.diagnose.judge.ranking import ranking
from rcc_sim.diagnose.judge.verdict import TOLERATED
from rcc_sim.diagnose.next_run.experiment import Experiment
from rcc_sim.diagnose.profiles.remainder import Remainder
from rcc_sim.diagnose.proof.by_log import LogEnergy
from rcc_sim.diagnose.proof.hold_out import Proof
from rcc_sim.diagnose.residuals.posed import at_own_rows
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.search.compete import Explanation
from rcc_sim.diagnose.search.taken import KeptOut

TOLD, MOVED = 0.9, 0.1
"""Share of its stated sd below which the sd of a figure must fall for it to be written;
or else by how many of them it must have moved. The figures of a fit belong together:
one that goes back to what the file says leaves the others with what it made up for."""


@dataclass(frozen=True)
class Diagnosis:
    """What :func:`rcc_sim.diagnose.run.diagnose` found.

    Parameters
    ----------
    vehicle : Vehicle
        The nominal model.
    problem : Problem
        The log ``shown`` as it was explained, and that model, without any profile.
    gaps : tuple of Gap
        Where each log and the nominal model part.
    status : str
        no_gap, explained, partly_explained or unexplained.
    short : tuple of str
        In what the causes come short of explaining all, in words.
    asserted : tuple of Asserted
        The causes, strongest first.
    found : Explanation
        Everything the competition found.
    fit : Fit
        Tolerances and the causes that stand.
    left : Remainder
        What none of the effects explains.
    proof : Proof
        What the causes do for rows that no fit saw.
    experiments : tuple of Experiment
        Runs that would settle what is tied, or wide; best first.
    kept_back : tuple of str
        Logs on which the proof is; empty: stretches of those that were explained.
    withdrawn : tuple of str
        Effects that explain what was fitted, and do nothing for what was held out.
    shown : int
        Log that is shown: of several, the one whose energy is farthest off.
    asked : tuple of str
        Effects that were considered alone; empty: all that could show.
    hidden : tuple of str
        Measured columns that were left out.
    by_log : tuple of LogEnergy
        Energy gap of each log, where there are several.
    """

    vehicle: Vehicle
    problem: Problem
    gaps: tuple[Gap, ...]
    status: str
    asserted: tuple[Asserted, ...]
    found: Explanation
    fit: Fit
    left: Remainder
    proof: Proof
    experiments: tuple[Experiment, ...] = ()
    kept_back: tuple[str, ...] = ()
    withdrawn: tuple[str, ...] = ()
    shown: int = 0
    asked: tuple[str, ...] = ()
    hidden: tuple[str, ...] = ()
    by_log: tuple[LogEnergy, ...] = ()
    short: tuple[str, ...] = ()

    def document(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        first = self.gap
        unexplained: dict[str, Any] = {
            "fraction": self.unexplained,
            "windows": self.left.windows if self.left.is_real else [],
        }
        if self.left.is_real:
            unexplained |= {"acts_as": self.left.acts_as, "follows": self.left.follows}
            unexplained |= {"may_be": list(self.may_be)} if self.may_be else {}
            if self.left.profile:
                unexplained["course"] = self.left.profile.document()
            if len(self.gaps) > 1:
                unexplained["log"] = self.gaps[self.left.log].log
        return {
            "schema": "rccsim.diagnosis/1",
            "log": first.log,
            "logs": [g.log for g in self.gaps],
            "vehicle": self.vehicle.name,
            "mode": first.mode,
            "status": self.status,
            "comes_short": list(self.short),
            "where": where(first),
            "candidates": list(self.asked),
            "hidden": list(self.hidden),
            "causes": [self._cause(a) for a in self.asserted],
            "ranking": ranking(self.found, list(self.asserted), self.left, self.status),
            "shrink": {
                "held_out": True,
                "logs": list(self.kept_back),
                "withdrawn": list(self.withdrawn),
                **asdict(self.proof.shrink),
                "energy_gap_percent_before": self.proof.before,
                "energy_gap_percent_after": self.proof.after,
                "energy_by_measured_torque": self.proof.by_torque,
                "courses_held_out": not self.courses_fitted,
            },
            "by_log": [
                {
                    "log": one.log,
                    "energy_gap_percent_before": one.before,
                    "energy_gap_percent_after": one.after,
                    "disagrees": one.disagrees,
                }
                for one in self.by_log
            ],
            "moved": self.moved,
            "moved_together": self.moved_together,
            "taken_up": self.taken_up,
            "kept_out": self.kept_out and asdict(self.kept_out),
            "foreseen": self.foreseen,
            "figures": {k: self._told(k, x) for k, x in self._moved().items()},
            "prices": self.prices and asdict(self.prices),
            "unexplained": unexplained,
            "next_experiment": [e.document() for e in self.experiments],
            "least_seen": self.found.least_seen,
            "not_identifiable": self.not_identifiable,
            "findings": [asdict(f) for f in first.findings],
        }

    def _cause(self, a: Asserted) -> dict[str, Any]:
        most = max([*self.found.ranking.values(), 1.0])
        gain = self.found.ranking.get(a.cause.effect, a.cause.gain)
        return {
            "effect": a.cause.effect,
            "probability": a.probability,
            "parameters": a.parameters,
            "varies": bool(a.cause.profiles),
            "indistinguishable_from": list(a.cause.tied),
            "instead": {
                effect: {k: e.document() for k, e in own.items()}
                for effect, own in a.instead.items()
            },
            "explains": min(max(gain, 0.0) / most, 1.0),
            "nats": a.cause.gain,
            "energy_wh": self.prices and self.prices.causes[a.cause.effect],
        }

    @property
    def gap(self) -> Gap:
        """Gap of the log that is shown."""
        return self.gaps[self.shown]

    @property
    def may_be(self) -> tuple[str, ...]:
        """Rare effects, asked for by name alone, that leave just what is left."""
        left = (self.left.acts_as, self.left.follows) if self.left.is_real else None
        told = {*self.asked, *(a.cause.effect for a in self.asserted)}
        known = self.vehicle.known.values()
        return tuple(e.id for e in known if e.left_as == left and e.id not in told)

    @property
    def is_tied(self) -> bool:
        """Whether something else would do in the place of a cause."""
        return any(a.cause.tied for a in self.asserted)

    @cached_property
    def foreseen(self) -> dict[str, float]:
        """Share of what is left in each channel that its own past foresees.

        Of the log that is shown. A rough road, a filter in the sensor and something
        that is missing are foreseen; noise of a sensor is not.
        """
        fit, tracks = self.fit, self.found.engine.tracks
        each = zip(tracks, fit.noise, fit.residuals, strict=True)
        return {
            channel: white.foresees(left)
            for (log, channel), white, left in each
            if log == self.shown
        }

    @property
    def unexplained(self) -> float:
        """Share of the gap beyond noise that stays; all of it where nothing stands."""
        if self.status == "unexplained":
            return 1.0
        explained = max(self.proof.shrink.explained, 0.0)
        return 1.0 - explained if self.left.is_real else 0.0

    @property
    def courses_fitted(self) -> bool:
        """Whether the proof's rows gave the course of what varies over the drive."""
        return not self.kept_back and any(a.cause.profiles for a in self.asserted)

    @property
    def taken_up(self) -> bool:
        """Whether stated figures, as they moved, close a gap that is no cause's.

        Their sds allow it to the fit; to the energy all of them together do not. What
        is farther off than tolerances may explain takes up nothing.
        """
        before, after = self.proof.before, self.proof.after
        if self.status != "unexplained" or self.left.is_real or before is None:
            return False
        closed = not stays_off(before, after, doubtless=True)
        closed &= self.proof.shrink.explained >= 1 - SHRUNK
        far = farthest(self.moved, self.moved_together)
        return closed and bool(self.moved) and far <= TOLERATED

    @cached_property
    def prices(self) -> Prices | None:
        """What each cause adds to the energy of the log that is shown."""
        causes, charge = [a.cause for a in self.asserted], self.problem.charge
        simulated = self.gap.energy.simulated_wh
        return prices(
            self.plain, causes, self.fit.values, self.shown, charge, simulated
        )

    @cached_property
    def plain(self) -> Problem:
        """The same as ``problem``, at the log's own rows."""
        return at_own_rows(self.problem, self.gap.measured)

    @property
    def not_identifiable(self) -> list[str]:
        """Effects of which no likely strength would show in these logs."""
        told = {e for a in self.asserted for e in (a.cause.effect, *a.cause.tied)}
        return sorted(self.found.hidden - told)

    def figures(self) -> dict[str, Figure]:
        """Stated figures that the logs moved, with intervals."""
        stated = self.vehicle.figures()
        return {key: figure for key, figure in self._moved().items() if key in stated}

    def _moved(self) -> dict[str, Figure]:
        """Tolerances that the logs narrow or move, by key."""
        out = {}
        alike = [fit for a in self.asserted for fit in a.alike]
        for knob in self.fit.knobs:
            if knob.sd < inf and not knob.key.startswith((BIAS, OWN)):
                off = abs(self.fit.values[knob.key] - knob.value)
                sd = self.fit.sd_among(alike, knob.key)
                sd = min(sd * INTERVAL, knob.sd)
                if sd <= TOLD * knob.sd or off >= MOVED * knob.sd:
                    out[knob.key] = self._figure(knob, sd)
        return out

    def _told(self, key: str, figure: Figure) -> dict[str, float | None]:
        """Return what ``--json`` prints of a figure of the mended file."""
        stated = next(k.value for k in self.fit.knobs if k.key == key)
        low, high = figure.interval
        return {"stated": stated, "value": figure.value, "low": low, "high": high}

    def _figure(self, knob: Knob, sd: float) -> Figure:
        """Return a figure that the logs moved; its interval ends where it must."""
        value = self.fit.values[knob.key]
        low, high = max(value - Z_90 * sd, knob.low), min(value + Z_90 * sd, knob.high)
        return Figure(value, sd, low, high, self._source_of(knob.key))

    def _source_of(self, key: str) -> str:
        """Return where a figure comes from, and what the file stated before."""
        before = self.vehicle.figures().get(key)
        if before is None:
            return self.source
        told = f": {before.source}" if before.source else ""
        return f"{self.source}; stated {before.value:g}{told}"

    @cached_property
    def moved(self) -> dict[str, float]:
        """Stated figures that are off by their sds or more, in sds, farthest first."""
        return moved(self.fit, self.vehicle.figures())

    @cached_property
    def moved_together(self) -> float:
        """Sds by which one would be off that is as unlikely as all of them."""
        return moved_together(self.fit, self.vehicle.figures())

    @property
    def kept_out(self) -> KeptOut | None:
        """What gains enough for a cause, but for what so strong ones may leave."""
        return self.found.kept_out if self.asserted else None

    @property
    def elsewhere(self) -> dict[str, float]:
        """Stated figures so many sds off that they are those of another vehicle."""
        return {k: abs(x) for k, x in self.moved.items() if abs(x) > ANOTHER_VEHICLE}

    @property
    def source(self) -> str:
        """Where derived figures come from, and what their logs held back."""
        logs = "derived: " + ", ".join(g.log for g in self.gaps)
        return logs + f" without {', '.join(self.hidden)}" * bool(self.hidden)

    def effects(self) -> dict[str, dict[str, Figure]]:
        """Causes as the mended file states them; profiles are written apart.

        A tyre radius that moved within its sd is written as ``wheel_radius``, because
        logs hold speeds by the radius that the file states.
        """
        radius = self._moved().get(RADIUS)
        found = {"wheel_radius": {"scale": radius}} if radius else {}
        return found | {
            a.cause.effect: {
                k: Figure(
                    e.value,
                    e.sd,
                    e.low,
                    e.high,
                    self._source_of(f"effects.{a.cause.effect}.{k}") + _or_else(a),
                )
                for k, e in a.figures.items()
            }
            for a in self.asserted
        }


def _or_else(a: Asserted) -> str:
    """Return what the logs cannot tell from a cause, and how strong it would be."""
    told = [
        f"{effect} ({', '.join(f'{k} {e.value:.4g}' for k, e in own.items())})"
        for effect, own in a.instead.items()
    ]
    return f"; cannot be told from {' or '.join(told)}" if told else ""
