"""Write the pages that come from the code: `python docs/generate.py`.

A page per effect from the effect files, and the vehicle file's reference from the
models. `tests/docs` checks that what is committed is current.
"""

from __future__ import annotations

import sys
from math import isinf
from pathlib import Path
from typing import Any, get_args, get_origin

from rcc_sim.definitions.catalogue import effect_row
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.tables import ADVICE, Sensor
from rcc_sim.definitions.vehicle import ALWAYS, TABLES
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.similitude.unlikely import RATIOS
from rcc_sim.units import unit_of

DOCS = Path(__file__).resolve().parent
MADE = "<!-- written by docs/generate.py; edit the code instead -->\n\n"


def pages() -> dict[str, str]:
    """Return path below docs/ -> text, of every page that is generated."""
    found = {f"effects/{name}.md": effect_page(name) for name in EFFECTS}
    found["effects/README.md"] = effect_index()
    found["vehicle_file.md"] = vehicle_page()
    return found


def effect_page(name: str) -> str:
    """Return the page of one effect."""
    row = effect_row(name)
    lines = [f"# {row['title']}", "", f"Id: `{name}`", "", "```text", row["equation"]]
    lines += ["```", "", "## Parameters", ""]
    lines += _parameters(row["parameters"], row["files"])
    lines += ["", "At its neutral value the effect vanishes to the last bit.", ""]
    lines += ["## What shows it", "", f"{_sentence(row['seen_as'])}", ""]
    lines += [f"Channels: {_codes(row['channels'])}.", ""]
    ledger = f"`energy_{row['ledger']}_j`" if row["ledger"] else "none of its own"
    lines += [f"Line of the ledger: {ledger}.", ""]
    if row["needs"]:
        needs = _codes(row["needs"]).replace(" or ", "` or `")
        lines += [f"Needs in the vehicle file: {needs}.", ""]
    if row["excludes"]:
        lines += [f"Stands in place of: {_codes(row['excludes'])}.", ""]
    if EFFECTS[name].sensor:
        lines += ["It touches the log alone: the car drives the same.", ""]
    lines += [
        "## Try it",
        "",
        "```text",
        f"rccsim effects show {name} --plot {name}.png",
    ]
    lines += ["```", "", "## Source", "", f"{_sentence(row['source'])}", ""]
    return MADE + "\n".join(lines)


def _parameters(parameters: list[dict[str, Any]], files: list[str]) -> list[str]:
    lines = [
        "| parameter | unit | what | neutral | bounds | usual |",
        "|---|---|---|---|---|---|",
    ]
    for p in parameters:
        usual = f"{_number(p['typical_low'])} to {_number(p['typical_high'])}"
        if p["typical_low"] == p["typical_high"]:
            usual = "–"
        about = p["about"] + (" (may be left out)" if p["optional"] else "")
        lines.append(
            f"| `{p['name']}` | {p['unit']} | {_cell(about)} | {_number(p['neutral'])} "
            f"| {_number(p['low'])} to {_number(p['high'])} | {usual} |"
        )
    return [*lines, *(f"| `{name}` | | name of a file | | | |" for name in files)]


def effect_index() -> str:
    """Return the list of effects."""
    lines = [
        "# Effects",
        "",
        "Every term of the model that can be switched, found, or withheld; "
        "`rccsim effects` lists them too.",
        "",
        "| effect | what | parameters |",
        "|---|---|---|",
    ]
    for name in EFFECTS:
        row = effect_row(name)
        told = _codes([p["name"] for p in row["parameters"]] + row["files"])
        lines.append(f"| [`{name}`]({name}.md) | {_cell(row['title'])} | {told} |")
    return MADE + "\n".join(lines) + "\n"


SPEED_LOOP = [
    'With `mode = "speed"`, each tick of `loop_rate_hz`:',
    "",
    "1. The reference [m/s] becomes a motor speed by the file's tyre radius, whatever "
    "the true one is: ω_ref = v_ref · gear_ratio / radius_m. `speed_mps` of a log "
    "comes from the motor's speed the same way.",
    "2. Where |ω_ref| is below the dead zone (`effects.speed_dead_zone`), the motor "
    "gets no current and the integral is zeroed; where ω is below it, it is seen as 0.",
    "3. Else i_q = K_p (ω_ref − ω) + ∫ K_i (ω_ref − ω) dt, with the gains in A per "
    "rad/s and A per rad, limited by `max_current_a`, the braking limit and the "
    "battery's voltage. The integral waits while the current is at a limit and the "
    "error drives it further. At a reference of 0 it is zeroed.",
    "4. Torque is K_t i_q with K_t = 3/2 · poles / 2 · flux_linkage_wb.",
    "",
    "The model drives forwards: what a car does that rolls back after a stop is left "
    "out, and what its loop remembers of it may show as a load.",
    "",
]


def vehicle_page() -> str:
    """Return the reference of the vehicle file."""
    lines = [
        "# The vehicle file",
        "",
        "A TOML file. `rccsim vehicles new NAME` begins one, "
        "`rccsim vehicles validate` checks it, "
        "`rccsim vehicles show` prints every figure with its source.",
        "",
        "A **figure** is a number, a range `[low, high]`, or a table "
        "`{ value, sd, low, high, source }`; `sd` is one standard deviation of what it "
        "may be wrong by, and a `source` that begins with `guess` shows as one in "
        "every report. The unit is the last part of the key; all are SI.",
        "",
    ]
    for table, model in TABLES.items():
        need = "always needed" if table in ALWAYS else "where a command needs it"
        lines += [f"## `[{table}]`", "", f"{_doc(model)} ({need})".strip(), ""]
        lines += _keys(table, model)
        lines += SPEED_LOOP if table == "controller" else []
    lines += ["## `[sensors.COLUMN]`", "", _doc(Sensor), ""]
    lines += _keys("sensors", Sensor)
    lines += [
        "## `[effects.ID]`",
        "",
        "A table for each effect that the vehicle is known to have, with that effect's "
        "parameters as figures: [the effects](effects/README.md). "
        '`[effects] files = ["mine.py"]` adds effects of your own; '
        '`[effects] without = ["ID"]` takes one of the base away. '
        "The name of a file (a map, a road) counts from the vehicle's folder; one "
        "without a folder that is not there is looked for where vehicles are.",
        "",
        "## What is unlikely",
        "",
        "A number that does not grow with a car's size tells a slip of a unit: it is "
        "said by `vehicles validate`, `check`, `gap`, `diagnose` and `simulate`, and "
        "refused by none.",
        "",
        "| figure | number | from | to | |",
        "|---|---|---|---|---|",
        *(
            f"| `{r.key}` | {r.what} | {r.low:g} | {r.high:g} | {_cell(r.hint)} |"
            for r in RATIOS
        ),
        "",
    ]
    return MADE + "\n".join(lines)


def _doc(model: type) -> str:
    text = " ".join((model.__doc__ or "").split())
    told = text.partition(": ")[2]
    return _sentence(told) if told else ""


def _keys(table: str, model: Any) -> list[str]:
    lines = ["| key | unit | kind | needed | |", "|---|---|---|---|---|"]
    for key, field in model.model_fields.items():
        kind = _kind(field.annotation)
        unit = unit_of(key) if kind.startswith("figure") else ""
        if table == "sensors" and unit == "1" and key != "scale_sd":
            unit = "the column's"
        need = "yes" if field.is_required() else ""
        advice = _cell(ADVICE.get(f"{table}.{key}", ""))
        lines.append(f"| `{key}` | {unit} | {kind} | {need} | {advice} |")
    return [*lines, ""]


def _kind(annotation: Any) -> str:
    """Return what a key takes, in words."""
    if annotation is Figure:
        return "figure"
    if annotation in (str, int):
        return "text" if annotation is str else "whole number"
    origin, inside = get_origin(annotation), get_args(annotation)
    parts = [a for a in inside if a is not type(None) and not hasattr(a, "func")]
    if str(origin) == "typing.Literal":
        return " or ".join(f'`"{a}"`' for a in inside)
    if origin is list:
        return "list of numbers" if inside == (float,) else "table of numbers"
    if origin is dict:
        return "table of figures"
    return _kind(parts[0])


def _codes(names: list[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _sentence(text: str) -> str:
    text = text.strip()
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _number(value: float) -> str:
    if isinf(value):
        return "∞" if value > 0 else "−∞"
    return f"{value:g}".replace("-", "−")


def main() -> None:
    """Write the pages; pages of effects that are gone are taken away."""
    made = pages()
    for path in (DOCS / "effects").glob("*.md"):
        if f"effects/{path.name}" not in made:
            path.unlink()
    for name, text in made.items():
        (DOCS / name).write_text(text, encoding="utf-8")
    sys.stdout.write(f"wrote {len(made)} pages\n")


if __name__ == "__main__":
    main()
