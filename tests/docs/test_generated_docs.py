"""The pages that are written from the code are current."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from rcc_sim.definitions.vehicle import TABLES
from rcc_sim.physics.effects import EFFECTS

DOCS = Path(__file__).resolve().parents[2] / "docs"
SPEC = importlib.util.spec_from_file_location("generate", DOCS / "generate.py")
generate = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(generate)
PAGES = generate.pages()


@pytest.mark.parametrize("name", PAGES)
def test_a_generated_page_is_current(name):
    committed = (DOCS / name).read_text(encoding="utf-8")
    assert committed == PAGES[name], "run `python docs/generate.py`"


def test_there_is_a_page_for_each_effect_and_none_for_what_is_gone():
    there = {path.stem for path in (DOCS / "effects").glob("*.md")}
    assert there == {*EFFECTS, "README"}


def test_the_vehicle_page_names_every_key_of_every_table():
    text = PAGES["vehicle_file.md"]
    for table, model in TABLES.items():
        assert f"## `[{table}]`" in text
        assert all(f"| `{key}` |" in text for key in model.model_fields)


def test_an_effect_page_gives_equation_bounds_and_source():
    for name, effect in EFFECTS.items():
        page = PAGES[f"effects/{name}.md"]
        assert effect.equation in page and effect.title in page
        assert effect.source[1:40] in page
        assert all(f"`{p.name}`" in page and p.about in page for p in effect.params)
