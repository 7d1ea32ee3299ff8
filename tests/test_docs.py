"""Commands and programs of README and docs run, each page's in an empty folder."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
LONG = ("fleets.md", "uncertainty.md", "report.md")
"""Pages whose commands the README has as well, on other input."""

SKIPPED = (
    "make ",
    "make\n",
    "pip ",
    "python -m pip",
    "git ",
    "cd ",
    "#",
    "rccsim demo",  # it has a test of its own
)


def blocks(page):
    """Return the fenced blocks that can run: line, language, text."""
    text = page.read_text(encoding="utf-8")
    found = re.finditer(r"^```(sh|console|python)\n(.*?)^```", text, re.M | re.S)
    return [(text.count("\n", 0, m.start()) + 1, m.group(1), m.group(2)) for m in found]


def commands(block):
    """Return what a person would type: after the $ signs, where there are any."""
    joined = block.replace("\\\n", " ")
    lines = joined.splitlines(keepends=True)
    if any(line.startswith("$ ") for line in lines):
        lines = [line.removeprefix("$ ") for line in lines if line.startswith("$ ")]
    return "".join(line for line in lines if not line.lstrip().startswith(SKIPPED))


@pytest.fixture
def environment(tmp_path_factory):
    """Return an environment in which `rccsim` and `python` are this checkout's."""
    tools = tmp_path_factory.mktemp("bin")
    for name, words in {"rccsim": "-m rcc_sim", "python": ""}.items():
        tool = tools / name
        tool.write_text(f'#!/bin/sh\nexec "{sys.executable}" {words} "$@"\n')
        tool.chmod(0o755)
    path = f"{tools}{os.pathsep}{os.environ['PATH']}"
    return os.environ | {"PATH": path, "MPLBACKEND": "agg"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=[pytest.mark.thorough] * (page.name in LONG))
        for page in PAGES
    ],
    ids=lambda page: page.name,
)
def test_every_block_of_a_page_runs_after_those_before_it(page, tmp_path, environment):
    for line, language, text in blocks(page):
        shell = ["bash", "-eu", "-c", commands(text)]
        python = [sys.executable, "-c", text]
        done = subprocess.run(
            python if language == "python" else shell,
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env=environment,
            timeout=900,
        )
        where = f"{page.name}:{line}\n{text}\n{done.stderr}"
        assert done.returncode == 0, where
        assert "error: " not in done.stderr, where  # left of a pipe


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_of_a_page_leads_to_a_file(page):
    links = re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8"))
    files = [link for link in links if "://" not in link]
    assert [f for f in files if not (page.parent / f).exists()] == []
