"""The competition: null, single effects, sets of effects and profiles."""
