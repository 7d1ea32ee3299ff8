"""``python -m rcc_sim`` is ``rccsim``."""

from rcc_sim.cli.app import main

main()
