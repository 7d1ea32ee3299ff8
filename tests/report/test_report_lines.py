"""Lines of a chart: thinned, packed and drawn without losing what matters."""

from __future__ import annotations

import base64
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcc_sim.report.lines import (
    HEIGHT,
    LEVELS,
    WIDTH,
    Line,
    Packer,
    bounds,
    extremes,
    path,
    shown,
    ticks,
)


def unpacked(told, axes):
    """Read a packed line as the page's script does."""
    axis = axes[told["axis"]]
    x = np.frombuffer(base64.b64decode(axis["x"]), "<u4") * axis["step"] + axis["start"]
    code = np.frombuffer(base64.b64decode(told["y"]), "<u2")
    y = told["low"] + code * told["step"]
    return x, np.where(code > LEVELS, np.nan, y)


@given(seed=st.integers(0, 10_000), rows=st.integers(5_000, 60_000))
def test_thinning_never_hides_a_spike(seed, rows):
    rng = np.random.default_rng(seed)
    x, y = np.arange(rows) / 100.0, rng.normal(size=rows)
    row = int(rng.integers(rows))
    y[row] = 50.0
    thin_x, thin_y = extremes(x, y, 1_000)
    assert len(thin_x) <= 1_002
    assert thin_x[np.argmax(thin_y)] == x[row]
    assert (thin_y.min(), thin_y.max()) == (y.min(), y.max())


@pytest.mark.parametrize("rows", [300, 50_000])
def test_a_line_is_cut_where_rows_were_lost(rows):
    x = np.arange(rows) / 100.0
    x[rows // 3 :] += 7.0
    y = np.sin(x)
    at, drawn = shown(x, y, 1_000)
    cut = np.flatnonzero(np.isnan(drawn))
    assert len(cut) == 1 and len(at) <= 1_010
    assert at[cut[0] - 1] == x[rows // 3 - 1] and at[cut[0] + 1] == x[rows // 3]
    assert path(Line("", "m", x, y), (0.0, x[-1]), (-1.0, 1.0)).count("M") == 2


@given(seed=st.integers(0, 10_000))
def test_a_drawn_path_reaches_every_spike(seed):
    rng = np.random.default_rng(seed)
    x, y = np.arange(60_000) / 100.0, rng.normal(size=60_000)
    row = int(rng.integers(60_000))
    y[row] = 40.0
    line = Line("", "m", x, y)
    points = re.findall(
        r"[ML](-?\d+) (-?\d+)", path(line, (0.0, x[-1]), bounds([line]))
    )
    across, down = np.array(points, dtype=float).T
    top = across[np.argmin(down)]
    assert abs(top - x[row] / x[-1] * WIDTH) <= 1
    assert down.min() == pytest.approx(HEIGHT * 0.05 / 1.1, abs=1)


@given(seed=st.integers(0, 10_000))
def test_a_packed_line_comes_back_within_a_step_of_its_range(seed):
    rng = np.random.default_rng(seed)
    x = np.cumsum(rng.uniform(0.001, 0.1, 2_000)) + 5.0
    y = rng.normal(size=2_000) * 10.0 ** rng.integers(-6, 7)
    y[rng.integers(0, 2_000, 30)] = np.nan
    packer = Packer(1, 2_000)
    back_x, back_y = unpacked(packer.pack(Line("", "m", x, y)), packer.axes)
    assert back_x == pytest.approx(x, abs=1e-8 * np.ptp(x))
    assert np.array_equal(np.isnan(back_y), np.isnan(y))
    assert np.nanmax(np.abs(back_y - y)) <= np.nanmax(np.ptp(y[~np.isnan(y)])) / LEVELS


@pytest.mark.parametrize("values", [[], [np.nan] * 3, [4.0] * 3, [12.0, 12.0 + 4e-15]])
def test_a_line_of_nothing_or_of_one_value_has_a_range_to_be_drawn_in(values):
    line = Line("", "m", np.arange(len(values), dtype=float), np.array(values))
    low, high = bounds([line])
    assert high - low > 0.1
    assert 2 <= len(ticks(low, high)) <= 8
    packer = Packer(1, 3)
    assert np.array_equal(
        unpacked(packer.pack(line), packer.axes)[1], np.array(values), equal_nan=True
    ) or np.ptp(values) == pytest.approx(0.0, abs=1e-12)


def test_a_gap_in_a_line_stays_a_gap():
    y = np.array([1.0, 2.0, np.nan, 3.0, 4.0])
    line = Line("", "m", np.arange(5.0), y)
    assert path(line, (0.0, 4.0), (0.0, 5.0)).count("M") == 2


@given(
    low=st.floats(-1e6, 1e6), size=st.floats(1e-3, 1e7), most=st.sampled_from([4, 5, 6])
)
def test_marks_are_few_round_inside_and_told_exactly(low, size, most):
    found = ticks(low, low + size, most)
    values = [value for value, _ in found]
    assert 1 <= len(found) <= most + 2
    assert all(low - 1e-6 * size <= v <= low + size * (1 + 1e-6) for v in values)
    texts = [float(text.replace("−", "-")) for _, text in found]
    assert texts == pytest.approx(values, rel=1e-9, abs=1e-9 * size)
