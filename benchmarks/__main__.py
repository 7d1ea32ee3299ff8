"""`python -m benchmarks`: every timing beside peers, one after the other."""

from benchmarks import effect_cost, kernel, peers, sweep

kernel.main()
peers.main()
effect_cost.main()
sweep.main()
