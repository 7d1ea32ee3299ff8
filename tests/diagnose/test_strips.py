import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcc_sim.diagnose.noise.strips import Strips

K = 4


def a_sheet(rng, height):
    """Columns with a run of rows each, some of none, and whole rows: and as it is."""
    first = rng.integers(0, height, K)
    length = [int(rng.integers(0, height - a + 1)) for a in first]
    dense = np.zeros((height, K))
    rows = np.flatnonzero(rng.random(height) < 0.3)
    runs = []
    for j, (a, n) in enumerate(zip(first, length, strict=True)):
        dense[a : a + n, j] = rng.standard_normal(n)
        dense[rows, j] = 0.0
        runs.append(dense[a : a + n, j].copy())
    dense[rows] = rng.standard_normal((len(rows), K))
    return Strips((height, K), rows, dense[rows], np.arange(K), first, runs), dense


@given(seed=st.integers(0, 999), sheets=st.integers(1, 3))
def test_products_of_strips_are_those_of_the_whole_matrix(seed, sheets):
    rng = np.random.default_rng(seed)
    pairs = [a_sheet(rng, int(rng.integers(1, 30))) for _ in range(sheets)]
    strips = Strips.stacked([one for one, _ in pairs])
    dense = np.vstack([whole for _, whole in pairs])
    weight, other = rng.random(len(dense)), rng.standard_normal((len(dense), 3))
    assert strips.toarray() == pytest.approx(dense)
    assert strips.gram() == pytest.approx(dense.T @ dense)
    assert strips.onto(other) == pytest.approx(dense.T @ other)
    assert strips.onto(other[:, 0]) == pytest.approx(dense.T @ other[:, 0])
    assert strips.times(weight).toarray() == pytest.approx(weight[:, None] * dense)
    assert Strips.of(dense).gram() == pytest.approx(dense.T @ dense)
