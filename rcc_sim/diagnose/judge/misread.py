"""What to say of a log once it is explained: sensors that the rest contradicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot

from rcc_sim.analyse.logcheck.finding import MEASURED, Finding
from rcc_sim.definitions.vehicle import DELAYS
from rcc_sim.diagnose.causes.cause import DRAGS, Cause
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import BIAS, bias_key, offsets_of, scale_key
from rcc_sim.diagnose.fitting.pulls import pulled
from rcc_sim.diagnose.judge import restless
from rcc_sim.diagnose.judge.direct import disagreeing
from rcc_sim.diagnose.judge.restless import Mask
from rcc_sim.diagnose.judge.verdict import TOLERATED
from rcc_sim.diagnose.profiles.altimeter import Wander
from rcc_sim.diagnose.profiles.forms import CORNERING
from rcc_sim.diagnose.profiles.remainder import Remainder
from rcc_sim.diagnose.residuals.lateness import as_late, battery_channel
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.shapes import ALTIMETER, ASKED, FELT, LATERAL, SCALE
from rcc_sim.diagnose.residuals.terminals import (
    CURRENT,
    RESISTANCE,
    VOLTAGE,
    fall_per_ampere,
)
from rcc_sim.physics.tables import BEFORE
from rcc_sim.simulate.drive import COMMANDS, is_on_stand
from rcc_sim.units import unit_of

NOTHING = 0.25
"""Share of what an altimeter shows below which next to nothing was felt of it."""

GAINED = 3.0
"""Standard deviations of a sensor's gain, or offset, from which on it is told."""

RECOVERS = 1.5
"""Times the resistance of a moment that a battery shows of a minute: what its file
states may be either."""

TURNS = ("yaw_rate_radps", "steer_cmd_rad")
"""Columns by which the model turns where the vehicle did."""

STATE = "[sensors.elevation_m] noise_sd states how far heights may be off"
WITHOUT = "--hide elevation_m does without them"

IS_FELT = (
    "is off by {}, now more, now less: the accelerometer felt other slopes",
    f"the fit takes those, the gap the heights as shown; {STATE}",
)
IS_STATED = (
    "is off by {}, if there is no drag that comes and goes",
    "the file allows as much: the fit takes it so",
)
MAY_BE = (
    "may be what leaves this gap, if it is off by {}, as a satellite receiver's are: "
    "a drag would do no better",
    f"{{}}; {STATE}; {WITHOUT}",
)
"""What to say of heights that are off, or may be, and what to do."""

SEEMS_SO = "what is left acts in bends, and may make it seem so"

UNTIL = (
    "was in force until the row that shows it, not from it on",
    "the fit takes it so; for the gap and other tools, move it up by a row",
)
MAY_BE_UNTIL = (
    "may have been in force until the row that shows it, not from it on",
    f"the fit takes it so, but {SEEMS_SO}",
)
"""What to say of a command that acted before its row, or may have, and what to do."""

TELLS = {
    False: "an accelerometer in the log tells them apart",
    True: "the accelerometer felt neither clearly",
}
"""What tells a slope from a drag, by whether the log has an accelerometer."""


COLD = "a cold or an old battery, or another"
WARM = "a warm battery, or another, or one of which the rest takes longer to fall"
"""Why a battery's resistance is more, or less, than is stated, as of a second."""


def findings_of(
    engine: Engine,
    fit: Fit,
    wanders: Mapping[int, Wander],
    causes: Sequence[Cause],
    left: Remainder,
    loose: Mask,
    log: int,
) -> tuple[Finding, ...]:
    """Return what to say of a log once it is explained.

    Parameters
    ----------
    engine, fit : Engine, Fit
        The logs, and tolerances and causes.
    wanders : mapping
        Log -> by how much its heights were off, where they were or may be.
    causes : sequence of Cause
        What stands.
    left : Remainder
        What they leave.
    loose : ndarray of bool
        Tracks of which what is left wanders.
    log : int
        Which of the logs.
    """
    problem = engine.problems[log]
    bends = left.log == log and left.is_real and left.acts_as in CORNERING
    return (
        *misread(fit, log, bends=bends),
        *behind(problem, causes, offsets_of(fit.values, log)),
        *until_their_rows(problem, bends=bends),
        *of_heights(wanders, log, accelerometer=FELT in problem.channels),
        *disagreeing(engine, fit, log),
        *restless.coming_and_going(engine, causes, loose, log),
        *pushed_along(problem, left if left.log == log else None),
        *without_bends(problem, causes),
        *unjudged(problem, causes),
    )


def misread(fit: Fit, log: int = 0, *, bends: bool = False) -> tuple[Finding, ...]:
    """Return what to say of the sensors of a log that the rest of it contradicts.

    Slopes that are not those of the road pass for offsets, which are told without them.
    What is left in ``bends`` may pass for a gain of what shows them.
    """
    shown = climbs(fit, log)
    told = gains(fit, log, bends=bends)
    return shown + told + (() if shown else offsets(fit, log))


def of_heights(
    wanders: Mapping[int, Wander], log: int = 0, *, accelerometer: bool = False
) -> tuple[Finding, ...]:
    """Return what to say of an altimeter that wanders, or may.

    ``accelerometer`` says whether the log has one.
    """
    if log not in wanders:
        return ()
    one = wanders[log]
    what, action = IS_FELT if one.is_felt else IS_STATED if one.is_stated else MAY_BE
    off = what.format(f"some {one.height:.1f} m")
    kind = "wander" if one.is_known else "may_wander"
    action = action.format(TELLS[accelerometer])
    return (Finding(kind, ALTIMETER, off, action=action, severity="warning"),)


def behind(
    problem: Problem, causes: Sequence[Cause], off: Mapping[str, float]
) -> tuple[Finding, ...]:
    """Return what to say of a slow log whose battery a fit takes to come late.

    By what is ``off`` in it. Not of a delay that the file states, nor of a cause.
    """
    told = DELAYS in (*problem.vehicle.effects, *(c.effect for c in causes))
    late, row = as_late(off, problem.row), problem.row
    if told or problem.torqued or abs(late) <= ASKED * row:
        return ()
    when = "later" if late > 0 else "earlier"
    what = f"comes some {abs(late):.2g} s {when} than the speed"
    action = "the fit takes it so; [sensors] latency_s states how late it is"
    of = battery_channel(problem)
    return (Finding("late", of, what, action=action, severity="warning"),)


def until_their_rows(problem: Problem, *, bends: bool) -> tuple[Finding, ...]:
    """Return what to say of commands that were in force when their rows were written.

    As of a loop that steps the vehicle, and then logs what it did and what it saw. What
    is left in ``bends`` may make a steering seem so.
    """
    columns = (COMMANDS.get(problem.vehicle.mode, ""), "steer_cmd_rad")
    found = []
    for column, held, unsure in zip(
        columns, problem.drive.held, (False, bends), strict=True
    ):
        if held != BEFORE or column not in problem.log:
            continue
        what, action = MAY_BE_UNTIL if unsure else UNTIL
        found += [Finding("until", column, what, action=action, severity="warning")]
    return tuple(found)


def pushed_along(problem: Problem, left: Remainder | None) -> tuple[Finding, ...]:
    """Return what to say of cornering that nothing explains, of a driven front axle.

    The model pushes along the body: what such an axle does to the turning under power
    is missing, and cornering figures may stand in for it.
    """
    if left is None or not left.is_real or left.acts_as not in CORNERING:
        return ()
    axle = problem.vehicle.drivetrain.driven_axle
    if axle == "rear" or problem.drive.imposed or not problem.drive.steered:
        return ()
    return (
        Finding(
            "front_push",
            "steer_cmd_rad",
            "turns an axle that is driven: the model pushes along the body, not along "
            "its wheels, and what that does to cornering under power stays",
            action='driven_axle = "rear" where that axle alone is driven; else drive '
            "gentler bends",
        ),
    )


def without_bends(problem: Problem, causes: Sequence[Cause]) -> tuple[Finding, ...]:
    """Return what to say of a log that does not tell where the vehicle turned.

    What bends take from its power is none of the model's, and drags are left to hold
    it: those named may be off by that, or stand for it.
    """
    log = problem.log
    if is_on_stand(log) or any(c in log for c in TURNS):
        return ()
    named = {e for c in causes for e in (c.effect, *c.tied)}
    if not named & DRAGS:
        return ()
    return (
        Finding(
            "no_bends",
            "yaw_rate_radps",
            "is not logged, nor steering: the model drives straight, and what bends "
            "take passes for a drag",
            action="log either, where the drive has bends",
        ),
    )


def unjudged(problem: Problem, causes: Sequence[Cause]) -> tuple[Finding, ...]:
    """Return what to say of a voltage that is not judged: its fall by the current.

    Nothing where that is what the file states, to a factor that a battery's recovery
    may make; where it tells nothing, that, unless a cause was found.
    """
    log, stated = problem.log, problem.vehicle.figures().get(RESISTANCE)
    if VOLTAGE not in log or VOLTAGE in problem.channels or stated is None:
        return ()
    seen = fall_per_ampere(log) if CURRENT in log else None
    if seen is None:
        silent = Finding(
            "not_judged",
            VOLTAGE,
            "tells nothing of the battery's resistance, for open_circuit_voltage_v "
            "has an sd or a range, or is not stated",
            action="state it without one, where it is known",
        )
        return () if causes else (silent,)
    ohm, error = seen
    near = abs(ohm - stated.value) <= GAINED * hypot(error, stated.tolerance)
    if near or stated.value / RECOVERS < ohm < RECOVERS * stated.value:
        return ()
    why = COLD if ohm > stated.value else WARM
    return (
        Finding(
            "resistance",
            VOLTAGE,
            f"falls by {ohm:.3g} V for each ampere more within a second, where the "
            f"file states {stated.value:.3g} Ω: {why}",
            action=f"state {RESISTANCE} so; what flows at its terminals hardly asks "
            "for it",
            severity="warning",
        ),
    )


def gains(fit: Fit, log: int = 0, *, bends: bool = False) -> tuple[Finding, ...]:
    """Return the sensors that a fit takes to read too much, or too little."""
    found = []
    for knob in fit.knobs:
        column = column_of(knob.key, log)
        pull = fit.values[knob.key] / knob.sd if column else 0.0
        if column == ALTIMETER or abs(pull) < GAINED:
            continue
        times = 1 + fit.values[knob.key]
        unsure = bends and column in LATERAL
        found.append(
            Finding(
                "misread",
                column,
                f"reads {times:.3g} times what the rest of the log says "
                f"({pull:+.1f} sd of its gain)",
                action=f"the fit takes it so{f', but {SEEMS_SO}' * unsure}; [sensors] "
                "scale_sd states how far it may be off",
                severity="warning",
                factor=round(1 / times, 4),
            )
        )
    return tuple(found)


def offsets(fit: Fit, log: int = 0) -> tuple[Finding, ...]:
    """Return the sensors that a fit takes to be off throughout by more than is likely.

    What else is the same all the time, as a load that the file does not have, looks so.
    """
    pulls = pulled(fit, GAINED)
    far = {
        column: (off, pulls[bias_key(log, column)])
        for column, off in offsets_of(fit.values, log).items()
        if column in MEASURED and bias_key(log, column) in pulls
    }
    return tuple(
        Finding(
            "misread",
            column,
            f"reads {abs(off):.3g} {unit_of(column)} too "
            f"{'much' if off > 0 else 'little'} throughout "
            f"({pull:+.1f} sd of its offset)",
            action="the fit takes it so, in place of what acts throughout; "
            "[sensors] bias_sd states how far it may be off",
            severity="warning",
        )
        for column, (off, pull) in far.items()
    )


def column_of(key: str, log: int) -> str:
    """Return the column of a gain of a sensor of a log; empty of any other figure."""
    column = key.removeprefix(f"{BIAS}{log}.").removesuffix(SCALE)
    return column if key == scale_key(log, column) else ""


def climbs(fit: Fit, log: int = 0) -> tuple[Finding, ...]:
    """Return what to say of an altimeter whose climbs were not those of the road.

    The model has them by the share that power, torque and accelerometer felt: none
    where it was out of step, or of another road.
    """
    key = scale_key(log, ALTIMETER)
    sd = next((k.sd for k in fit.knobs if k.key == key), 0.0)
    scale = fit.values.get(key, 0.0)
    if not sd or abs(scale) <= TOLERATED * sd:
        return ()
    felt = 1 - scale
    share = "next to nothing" if abs(felt) < NOTHING else f"some {100 * felt:.0f} %"
    return (
        Finding(
            "misread",
            ALTIMETER,
            f"shows climbs of which the rest of the log felt {share}: it is out of "
            "step, of another road, or badly scaled",
            action="the fit takes slopes as felt, the gap as shown; diagnose again "
            "with --hide elevation_m before any figure that moved is believed",
            severity="warning",
            factor=round(felt, 3),
        ),
    )
