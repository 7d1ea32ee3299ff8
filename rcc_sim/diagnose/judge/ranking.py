"""All candidates of a diagnosis, and how likely each is."""

from __future__ import annotations

from collections.abc import Mapping
from math import exp, log

from rcc_sim.diagnose.causes.cause import ENOUGH
from rcc_sim.diagnose.judge.asserted import Asserted
from rcc_sim.diagnose.judge.chances import EVEN, SOFT
from rcc_sim.diagnose.profiles.remainder import Remainder
from rcc_sim.diagnose.search.compete import Explanation


def ranking(
    found: Explanation, asserted: list[Asserted], left: Remainder, status: str = ""
) -> list[dict[str, float | str]]:
    """Return all candidates with their probabilities and what each explains alone.

    Each is weighed by the nats beyond those that it needs; nothing needs none. Where no
    cause stands, no candidate counts for more than what it needs, whatever it gained;
    a gap that stays unexplained is something unknown. Those that the logs cannot tell
    from a cause name it, and share its probability, which is that one of them acts.
    What the least sure cause leaves is the others'; something unknown's, if that cause
    varies and is no surer for what may be in its place.
    """
    gains: Mapping[str, float] = found.ranking
    tied = {e: a.cause.effect for a in asserted for e in a.cause.tied}
    sure = {a.cause.effect: a.probability for a in asserted}
    most = max([*gains.values(), left.evidence, 1.0])
    rest = max(1.0 - min(sure.values(), default=0.0), 0.0)
    beyond = {e: max(g, 0.0) - ENOUGH for e, g in gains.items()}
    if not sure:
        beyond = {e: min(x, 0.0) for e, x in beyond.items()}
    beyond = {e: x - SOFT * log(len(gains)) for e, x in beyond.items()}
    beyond |= {"unknown": left.evidence - left.enough, "none": 0.0}
    if status == "unexplained":
        beyond["unknown"] = max(beyond["unknown"], ENOUGH)
    free = {e: x for e, x in beyond.items() if e not in sure and e not in tied}
    likeliest = max(free.values())
    weights = {e: exp((x - likeliest) / SOFT) for e, x in free.items()}
    rivalled = any(a.cause.profiles and a.cause.rival for a in asserted)
    if rivalled or EVEN in sure.values():  # beside another vehicle's figures, who knows
        weights = {"unknown": 1.0}
    others = sum(weights.values())
    shared = {
        e: a.probability / (1 + len(a.cause.tied))
        for a in asserted
        for e in (a.cause.effect, *a.cause.tied)
    }
    rows: list[dict[str, float | str]] = []
    for effect in beyond:
        gain = gains.get(effect, left.evidence if effect == "unknown" else 0.0)
        chance = shared.get(effect, rest * weights.get(effect, 0.0) / others)
        share = min(max(gain, 0.0) / most, 1.0)
        rows.append(
            {
                "effect": effect,
                "probability": chance,
                "explains": share,
                "tied_with": tied.get(effect, ""),
            }
        )
    return sorted(
        rows,
        key=lambda r: (-float(r["probability"]), r["effect"] not in sure,
                       -float(r["explains"])),
    )  # fmt: skip
