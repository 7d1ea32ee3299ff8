"""`python -m benchmarks`: every timing beside peers, one after the other."""

<<<<<<< HEAD
from benchmarks import kernel, peers

kernel.main()
peers.main()
=======
from benchmarks import effect_cost, kernel

kernel.main()
effect_cost.main()
>>>>>>> h-a
