"""What is read is never overwritten, and no log counts twice."""

import pytest

from rcc_sim.cli.logs import keep, once
from rcc_sim.errors import InputError


def test_a_file_that_is_read_is_not_written(tmp_path):
    log, link = tmp_path / "log.csv", tmp_path / "link.csv"
    log.write_text("time_s\n0\n")
    link.symlink_to(log)
    for path in (log, link, tmp_path / "." / "log.csv"):
        with pytest.raises(InputError, match=r"--output: .*: is read here"):
            keep([str(log)], {"--html": None, "--output": path})
    keep([str(log), "rcc", "-"], {"--output": tmp_path / "new.csv"})


def test_a_log_that_is_given_twice_is_refused(tmp_path):
    one, two = str(tmp_path / "a.csv"), str(tmp_path / "b.csv")
    once([one, two, "-", "-"])
    with pytest.raises(InputError, match="given twice"):
        once([one, two, str(tmp_path / "x" / ".." / "a.csv")])
