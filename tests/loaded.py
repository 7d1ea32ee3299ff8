"""All that `rccsim` may load, loaded: what processes of the tests are forked from."""

import pkgutil
from importlib import import_module

from numba.core import registry

import rcc_sim
from rcc_sim.jit import cache_folder

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
    "typer._adapters",
    "typer._click.decorators",
)
"""What commands load only once they need it."""

for name in PARTS:
    import_module(name)
for module in pkgutil.walk_packages(rcc_sim.__path__, "rcc_sim."):
    if not module.name.endswith("__main__"):
        import_module(module.name)

cache_folder()
registry.cpu_target.target_context.refresh()  # what loads compiled kernels
