"""What each effect costs: UDDS commanded, with the effect against without it.

    python -m benchmarks.effect_cost

The reference car of `rccsim effects show --plot`, 1369 s at its controller's rate, with
lane changes where the effect shows in them. One row a second, so that the time is the
kernel's. Runs off and on in turn; the figures are the least processor time of the
rounds and their ratio. One car against itself shows the noise.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.report.effect_plot import reference_cars
from rcc_sim.simulate.run import LaneChanges, simulate

ROUNDS = 11
LATERAL = {"yaw_rate_radps", "accel_y_mps2"}


def main() -> None:
    """Print a line for each effect, dearest first."""
    udds = parse_cycle("udds")
    cycle = Cycle("udds at 0.416", udds.time_s, 0.416 * udds.speed_mps)
    rows = [cost(name, cycle) for name in EFFECTS]
    _, car, _ = reference_cars("gear_loss", EFFECTS["gear_loss"])
    for lanes in (None, LaneChanges(20.0)):
        least = timed([car, car], cycle, lanes)
        what = "with lane changes" if lanes else "straight"
        print(f"noise, {what}: {least[1] / least[0]:.3f} of {1e3 * least[0]:.0f} ms")
    print(f"{'effect':28}{'off, ms':>9}{'on, ms':>9}{'ratio':>8}")
    for ratio, off, name, lateral in sorted(rows, reverse=True):
        drive = "  lane changes" if lateral else ""
        print(f"{name:28}{1e3 * off:9.1f}{1e3 * off * ratio:9.1f}{ratio:8.2f}{drive}")
        sys.stdout.flush()


def cost(name: str, cycle: Cycle) -> tuple[float, float, str, bool]:
    """Return on over off, the time off [s], the effect, whether lanes were changed."""
    effect = EFFECTS[name]
    _, off, on = reference_cars(name, effect)
    lateral = bool(LATERAL & set(effect.channels)) and not effect.sensor
    least = timed([off, on], cycle, LaneChanges(20.0) if lateral else None)
    return least[1] / least[0], least[0], name, lateral


def timed(cars: list[Vehicle], cycle: Cycle, lanes: LaneChanges | None) -> list[float]:
    """Return the least time of each car [s], taken in turn."""
    options: dict[str, object] = {"output_rate": 1.0, "lanes": lanes}
    mode = cars[0].controller.mode if cars[0].controller else ""
    if mode == "throttle":
        options["throttle"] = cycle.time_s, 0.5 * cycle.speed_mps / cycle.max_speed
        cycle = Cycle(cycle.name, cycle.time_s, np.zeros_like(cycle.speed_mps))
    least = [float("inf")] * len(cars)
    for k in range(ROUNDS + 1):
        for i, car in enumerate(cars):
            start = time.process_time()
            simulate(car, cycle, **options)
            if k > 0:  # the first compiles, or reads what was compiled
                least[i] = min(least[i], time.process_time() - start)
    return least


if __name__ == "__main__":
    main()
