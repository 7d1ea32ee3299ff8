"""`python -m benchmarks`: every timing beside peers, one after the other."""

from benchmarks import kernel, peers

kernel.main()
peers.main()
