"""References that were logged as they were sent, and hold until the next one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rcc_sim.diagnose.cause import ENOUGH
from rcc_sim.diagnose.compete import Explanation
from rcc_sim.diagnose.engine import Engine

LATE = "actuation_delay"
"""What a motor seems to have whose reference holds between the rows of its log."""

ROWS = 1.5
"""Rows up to which a delay may be that of a reference that holds: half of one."""


def as_sent(
    engine: Engine, found: Explanation, explained: Callable[[Engine], Explanation]
) -> tuple[Engine, Explanation]:
    """Return logs and explanation, references holding where that is as likely.

    A reference that runs straight from row to row leads one that holds by half a row. A
    motor that seems to be late by no more is explained once more with a reference that
    holds; it is taken if no cause fewer costs more nats than a cause must gain.
    """
    key = f"effects.{LATE}.delay_s"
    row = engine.problems[0].row
    named = LATE in {c.effect for c in found.causes}
    straight = [p for p in engine.problems if not p.drive.held[0]]
    if not (named and straight) or found.fit.values[key] > ROWS * row:
        return engine, found
    held = Engine(
        [
            replace(p, drive=replace(p.drive, held=(True, p.drive.held[1])))
            for p in engine.problems
        ]
    )
    again = explained(held)
    fewer = len(found.causes) - len(again.causes)
    if again.fit.score + ENOUGH * fewer <= found.fit.score:
        return engine, found
    return held, again
