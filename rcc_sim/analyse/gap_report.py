"""A gap as a JSON object, as rows, and as the tables of one screen."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from rcc_sim.analyse.gap import Gap
from rcc_sim.analyse.gap_energy import COVERAGE, EnergyGap

SHOWN = 5
"""Windows, and unsure figures, that the screen shows."""


def document(gap: Gap) -> dict[str, Any]:
    """Return what ``--json`` prints."""
    return {
        "schema": "rccsim.gap/1",
        "log": gap.log,
        "vehicle": gap.vehicle,
        "mode": gap.mode,
        "energy": energy_block(gap.energy),
        "u_val": gap.energy.u_val if gap.energy.at else None,
        **where(gap),
        "theil": {
            c.channel: asdict(c.theil) if c.theil else None for c in gap.channels
        },
        "findings": [asdict(finding) for finding in gap.findings],
        "notes": list(gap.notes),
    }


def where(gap: Gap) -> dict[str, Any]:
    """Return the ``where`` block: energy, channels, regimes, stages, windows."""
    return {
        "energy": energy_block(gap.energy),
        "channels": [{**asdict(c), "ratio": c.ratio} for c in gap.channels],
        "regimes": [asdict(regime) for regime in gap.regimes],
        "stages": stages(gap),
        "figures": figures(gap),
        "windows": [asdict(window) for window in gap.windows],
    }


def stages(gap: Gap) -> list[dict[str, Any]]:
    """Return the stages, each also in percent of what was measured."""
    whole = abs(gap.energy.measured_wh or 0.0)
    return [
        {
            "stage": s.stage,
            "gap_wh": s.gap_wh,
            "u_val_wh": s.u_val_wh,
            "gap_percent": 100 * s.gap_wh / whole if whole else None,
            "share": s.share,
        }
        for s in gap.stages
    ]


def figures(gap: Gap) -> list[dict[str, Any]]:
    """Return what one sd of each stated figure does to the energy, largest first."""
    return [{"key": key, "u_wh": wh} for key, wh in gap.energy.by_figure.items()]


def energy_block(energy: EnergyGap) -> dict[str, Any]:
    """Return the energies, the gap, and its uncertainty in its parts."""
    return {
        "at": energy.at or None,
        "measured_wh": energy.measured_wh,
        "simulated_wh": energy.simulated_wh,
        "gap_wh": energy.gap_wh,
        "gap_percent": energy.gap_percent,
        "u_val_wh": energy.u_val if energy.at else None,
        "u_expanded_wh": energy.expanded if energy.at else None,
        "u_noise_wh": energy.noise_wh,
        "u_tolerance_wh": energy.tolerance_wh,
        "u_numerical_wh": energy.numerical_wh,
        "u_bias_wh": energy.bias_wh,
        "coverage": COVERAGE,
        "within": energy.within,
    }


def rows(gap: Gap) -> list[dict[str, Any]]:
    """Return everything as one long table: part, name, figure, value."""
    out: list[dict[str, Any]] = []

    def put(part: str, name: str, figures: dict[str, Any]) -> None:
        out.extend(
            {"part": part, "name": name, "figure": key, "value": value}
            for key, value in figures.items()
            if isinstance(value, int | float) and not isinstance(value, bool)
        )

    put("energy", gap.energy.at, energy_block(gap.energy))
    for c in gap.channels:
        put("channel", c.channel, {**asdict(c), "ratio": c.ratio})
    for regime in gap.regimes:
        put("regime", regime.regime, asdict(regime))
    for stage in gap.stages:
        put("stage", stage.stage, asdict(stage))
    for figure in figures(gap):
        put("figure", figure["key"], figure)
    for window in gap.windows:
        put("window", window.channel, asdict(window))
    return out


def headline(gap: Gap, model: str = "") -> str:
    """Return the energy gap and its verdict in one line; ``model`` names the file."""
    e, model = gap.energy, model or gap.vehicle
    if e.gap_wh is None:
        return f"{gap.log} against {model} ({gap.mode}): no energy was logged"
    percent = "" if e.gap_percent is None else f" ({e.gap_percent:+.3g} %)"
    verdict = "within" if e.within else "beyond"
    return (
        f"{gap.log} against {model} ({gap.mode}), at the {e.at}: measured "
        f"{e.measured_wh:.4g} Wh, simulated {e.simulated_wh:.4g} Wh, "
        f"gap {e.gap_wh:+.3g} Wh{percent}; {verdict} {COVERAGE:g} × u_val = "
        f"{e.expanded:.3g} Wh"
    )


def tables(gap: Gap) -> list[tuple[str, list[dict[str, Any]]]]:
    """Return the tables of one screen, each with its title."""
    channels: list[dict[str, Any]] = [
        {
            "channel": c.channel,
            "rmse": c.rmse,
            "bias": c.bias,
            "noise": c.noise,
            "tolerance": c.tolerance,
            "ratio": c.ratio,
            "score": c.score,
        }
        for c in gap.channels
    ]
    regimes: list[dict[str, Any]] = [
        {
            "regime": r.regime,
            "time_s": r.time_s,
            "gap_wh": r.gap_wh,
            "u_val_wh": r.u_val_wh,
            "share": r.share,
        }
        for r in gap.regimes
    ]
    top = sorted(gap.windows, key=lambda w: -w.share)[:SHOWN]
    found: list[dict[str, Any]] = [
        asdict(w) for w in sorted(top, key=lambda w: w.start_s)
    ]
    parts = [
        ("By channel", channels),
        ("By kind of driving", regimes),
        ("By stage", stages(gap)),
        ("What the file is unsure of, one sd more", figures(gap)[:SHOWN]),
        ("When", found),
    ]
    return [(title, table) for title, table in parts if table]
