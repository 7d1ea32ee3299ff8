"""Timings against peers; `python -m benchmarks` runs them all."""
