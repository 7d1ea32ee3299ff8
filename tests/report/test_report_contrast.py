"""Colours of the page against what they stand on, by WCAG 2."""

from __future__ import annotations

import re
from importlib import resources

import pytest

STYLE = resources.files("rcc_sim.report").joinpath("report.css").read_text("utf-8")
THEMES = [
    dict(re.findall(r"--(\w+): (#[0-9a-f]{6})\b(?![0-9a-f])", block))
    for block in re.findall(r"\{([^{}]*--paper:[^{}]*)\}", STYLE)
]


def luminance(colour):
    """Relative luminance of WCAG 2 of #rrggbb, #rgb not being used."""
    parts = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    r, g, b = (
        c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in parts
    )
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


def contrast(one, other):
    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", THEMES, ids=["light", "dark", "dark by button"])
def test_text_has_contrast_aa_and_lines_have_three_to_one(theme):
    text = ("ink", "soft", "link", "good", "bad")
    for name in text:
        for ground in ("paper", "card"):
            assert contrast(theme[name], theme[ground]) >= 4.5, (name, ground)
    lines = ("m", "b", "a", *(f"s{k}" for k in range(6)))
    for name in lines:
        assert contrast(theme[name], theme["paper"]) >= 3.0, name
    for tint in (f"t{k}" for k in range(9)):
        for name in ("m", "b", "a"):
            assert contrast(theme[name], theme[tint]) >= 3.0, (name, tint)


def test_both_dark_themes_are_one():
    assert len(THEMES) == 3 and THEMES[1] == THEMES[2] != THEMES[0]


def test_white_against_black_is_21_to_1():
    assert contrast("#ffffff", "#000000") == pytest.approx(21.0)
