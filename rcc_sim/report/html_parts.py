"""Parts that pages share: sections, tables, bars, figures at the top."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rcc_sim.physics.effects import EFFECTS
from rcc_sim.report.text import Markup, tag

SCALE = 1000.0
"""Width of a bar's own coordinates."""


OTHER_DRIVE = "drive taken otherwise than logged (road, torque)"
"""What the energy is called that another drive than the gap's takes."""

SHIFTS, METERS = "shifts of stated figures", "offsets of the meters"
"""What the energy is called by which the model's changes; that meters read too much."""

OR_TIE = " or what ties with it"
"""What is said of a tie's energy, which is that of its first."""

SMALL = 1e-3
"""Share of the energy below which a step of it is not shown."""

OTHERS = {"none": "no effect at all", "unknown": "something not in the library"}
"""What competes with the effects -> what people call it."""


@dataclass(frozen=True)
class Column:
    """One column of a table: its heading, its key in the rows, and whether numeric."""

    head: str
    key: str
    number: bool = False


def section(name: str, title: str, *content: object) -> Markup:
    """Return a section with a heading; nothing if it has no content."""
    if not any(content):
        return Markup("")
    return tag(
        "section",
        tag("h2", title),
        *content,
        id=name,
    )


def table(
    columns: Sequence[Column],
    rows: Sequence[Mapping[str, Any]],
    caption: str = "",
) -> Markup:
    """Return a table; on a narrow screen each row stands downwards.

    Cells are text or Markup; a row with a true ``total`` is printed bold; columns that
    no row fills are left out.
    """
    if not rows:
        return Markup("")
    kept = [c for c in columns if any(row.get(c.key) not in (None, "") for row in rows)]
    head = tag(
        "thead",
        tag("tr", *(tag("th", c.head, scope="col", class_=_class(c)) for c in kept)),
    )
    body = tag("tbody", *(_row(kept, row) for row in rows))
    told = tag("caption", caption) if caption else ""
    return tag("div", tag("table", told, head, body, class_="stack"), class_="scroll")


def _row(columns: Sequence[Column], row: Mapping[str, Any]) -> Markup:
    cells = []
    for k, column in enumerate(columns):
        content = row.get(column.key)
        if content is None:
            content = ""
        if k == 0:
            cells.append(tag("th", content, scope="row"))
        else:
            is_bar = isinstance(content, Markup) and content.startswith("<svg")
            named = column.head if content != "" and not is_bar else None
            classes = "bar" if is_bar else _class(column)
            cells.append(tag("td", content, class_=classes, data_head=named or None))
    return tag("tr", *cells, class_="total" if row.get("total") else None)


def _class(column: Column) -> str | None:
    return "n" if column.number else None


def bar(reach: tuple[float, float], low: float, high: float, kind: str) -> Markup:
    """Return a bar over ``reach`` on an axis from ``low`` to ``high``, zero marked.

    It says nothing that the number beside it does not.
    """
    size = (high - low) or 1.0
    a, b = sorted(min(max((v - low) / size, 0.0), 1.0) * SCALE for v in reach)
    base = (min(max(0.0, low), high) - low) / size * SCALE
    box = tag(
        "rect",
        x=f"{a:.1f}",
        y="2",
        width=f"{max(b - a, 2.0):.1f}",
        height="16",
        class_=f"fill-{kind}",
    )
    line = tag("path", d=f"M{base:.1f} 0V20", class_="zero")
    return tag(
        "svg",
        box,
        line,
        viewBox="0 0 1000 20",
        preserveAspectRatio="none",
        aria_hidden="true",
    )


def cards(entries: Sequence[tuple[str, str, str]]) -> Markup:
    """Return figures at the top: what, the figure, and a word on it."""
    told = [
        tag(
            "div",
            tag("dt", what),
            tag("dd", figure, tag("small", word) if word else ""),
        )
        for what, figure, word in entries
    ]
    return tag("dl", *told, class_="cards") if told else Markup("")


def effect_title(name: str) -> str:
    """Return what people call an effect; its id with spaces where it is not shipped."""
    if name in OTHERS:
        return OTHERS[name]
    return EFFECTS[name].title if name in EFFECTS else name.replace("_", " ")


def effect_name(name: str) -> Markup:
    """Return an effect's title with its id, if that says more."""
    title = effect_title(name)
    if title == name:
        return tag("span", title)
    return tag("span", title, " ", tag("code", name))
