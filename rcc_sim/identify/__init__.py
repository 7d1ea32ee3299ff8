"""A car's parameters from what a lab can measure: I_z, B, J, road load, CG.

Numbers and arrays in, frozen results out. `bifilar` and `step_response` load neither
numpy nor scipy until they are given a log; `cg` never does.
"""
