"""Is a log sound: time base, sensors, units and signs, by what the log itself shows."""

from rcc_sim.analyse.logcheck.check import check_log
from rcc_sim.analyse.logcheck.finding import Checked, Finding
from rcc_sim.analyse.logcheck.reading import check_reading, file_findings

__all__ = ["Checked", "Finding", "check_log", "check_reading", "file_findings"]
