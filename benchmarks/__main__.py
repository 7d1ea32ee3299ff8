"""`python -m benchmarks`: every benchmark, one after the other."""

from benchmarks import effect_cost, kernel

kernel.main()
effect_cost.main()
