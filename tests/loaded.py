"""All that `rccsim` may load, loaded: what processes of the tests are forked from."""

import pkgutil
from importlib import import_module

import rcc_sim

PARTS = (
    "matplotlib.figure",
    "numba.np.arraymath",
    "pandas",
    "pyarrow.csv",
    "pyarrow.parquet",
    "scipy.interpolate",
    "scipy.optimize",
    "scipy.signal",
    "scipy.stats",
    "tomlkit",
)
"""What commands load only once they need it."""

for name in PARTS:
    import_module(name)
for module in pkgutil.walk_packages(rcc_sim.__path__, "rcc_sim."):
    if not module.name.endswith("__main__"):
        import_module(module.name)
