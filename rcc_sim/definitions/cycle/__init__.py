"""Drive cycles: speed over time, and the user's words for them."""

from rcc_sim.definitions.cycle.series import MAX_ROWS, Cycle, join
from rcc_sim.definitions.cycle.words import list_cycles, parse_cycle, read_cycle

__all__ = ["MAX_ROWS", "Cycle", "join", "list_cycles", "parse_cycle", "read_cycle"]
