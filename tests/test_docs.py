"""The README's commands and programs run, in order, in an empty folder."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

README = Path(__file__).resolve().parents[1] / "README.md"
SKIPPED = ("make ", "make\n", "pip ", "python -m pip", "git ", "cd ", "#")


def blocks():
    """Return the fenced blocks that can run: line, language, text."""
    text = README.read_text(encoding="utf-8")
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
@pytest.mark.skipif(not README.is_file(), reason="there is no README.md")
def test_every_block_of_the_readme_runs_after_those_before_it(tmp_path, environment):
    for line, language, text in blocks():
        shell = ["bash", "-eu", "-c", commands(text)]
        python = [sys.executable, "-c", text]
        done = subprocess.run(
            python if language == "python" else shell,
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env=environment,
            timeout=300,
        )
        where = f"README.md:{line}\n{text}\n{done.stderr}"
        assert done.returncode == 0, where
        assert "error: " not in done.stderr, where  # left of a pipe
