"""Arrow's columns as arrays, and what reading a log costs."""

import subprocess
import sys

import numpy as np
import pyarrow as pa

from rcc_sim.trace import from_arrow


def test_gaps_slices_and_empty_chunks():
    """Each kind of chunk gives the numbers that Arrow itself prints."""
    whole = pa.array([1.0, None, 3.0, float("nan")])
    column = pa.chunked_array([whole, whole[2:2], whole[1:3], pa.array([7.5])])
    expected = [np.nan if x is None else x for x in column.to_pylist()]
    found = from_arrow(column)
    np.testing.assert_array_equal(found, expected)
    assert found.flags.writeable and found.dtype == float
    assert from_arrow(pa.chunked_array([], pa.float64())).shape == (0,)


def test_reading_a_log_loads_no_pandas(tmp_path):
    """What takes longer to load than a log to read is loaded by nothing."""
    log = tmp_path / "log.csv"
    rows = "".join(f"{k / 100},{k / 50},\n" for k in range(300))
    log.write_text("time_s,speed_mps,yaw_rate_radps\n" + rows)
    told = subprocess.run(
        [
            sys.executable,
            "-c",
            "import sys; from rcc_sim.readers import read_log; "
            f"print(len(read_log({str(log)!r}).trace), 'pandas' in sys.modules)",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert told.stdout.split() == ["300", "False"]
