r"""How much an effect shows in a log, beyond what the stated tolerances can absorb.

With D the change that the effect makes in every channel, T the changes of one standard
deviation of each stated figure and each sensor's bias, and S the spectrum of what
sensors and rough road add, all on the drive without noise,

.. math:: \tfrac12 \left( D^* S^{-1} D - D^* S^{-1} T (I + T^* S^{-1} T)^{-1}
          T^* S^{-1} D \right)

is the expected logarithm of the likelihood ratio (nats). It is an estimate: S is taken
as stationary, from one drive, and the changes as linear. [1]_

References
----------
.. [1] S. M. Kay, Fundamentals of Statistical Signal Processing: Detection Theory,
       Prentice Hall, 1998, ch. 4 and 5 (matched filter; linear nuisance parameters).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rcc_sim.blind.bases import TOLERANCES, shifted
from rcc_sim.blind.drives import TIMING
from rcc_sim.blind.plant import COLUMNS, SINKS, Drive, Truth
from rcc_sim.blind.sensors import SENSORS

Array = NDArray[np.float64]
COARSE_EV_TICK = 5e-3  # s; of the controller and the step, where only changes matter
COARSE_EV_V_LOW = 0.5  # m/s
NO_WITNESS = {"rc": {"elevation_m"}, "ev": {"elevation_m", "speed_mps", "accel_x_mps2"}}
"""Channels by which no model is judged: where no command is logged, the motion is what
drives it, and how far that falls short of what was asked for is not known."""

SMOOTHED = 25  # lines of the spectrum over which it is averaged
LINE = 2048  # commands under way that there is room for


def simulated(
    p: Truth, d: Drive, T_tick: float, substeps: int
) -> tuple[Array, dict[str, float]]:
    """Run the plant: its rows, and its books [J] by name."""
    from rcc_sim.blind.plant_run import run
    from rcc_sim.jit import compiled

    rows = np.zeros((len(np.asarray(d.rows)), COLUMNS))
    books = np.zeros(len(SINKS))
    with np.errstate(all="ignore"):
        compiled(run)(p, d, T_tick, substeps, rows, books, np.zeros(LINE))
    return rows, dict(zip(SINKS, books.tolist(), strict=True))


def fine(p: Truth, d: Drive, family: str) -> tuple[Array, dict[str, float]]:
    """Run the plant at its own step."""
    how = TIMING[family]
    return simulated(p, d, how.tick, how.substeps)


def coarse(p: Truth, d: Drive, family: str) -> Array:
    """Run the plant at a long step, for changes alone: its rows."""
    how = TIMING[family]
    tick = how.tick if family == "rc" else COARSE_EV_TICK
    v_low = p.v_low if family == "rc" else COARSE_EV_V_LOW
    per = round(tick / (how.tick / how.substeps))
    rows = np.maximum(np.asarray(d.rows) // per, 1)
    return simulated(p._replace(v_low=v_low), d._replace(rows=rows), tick, 1)[0]


def spectrum(residual: Array, white: float) -> Array:
    """Smoothed power of a residual, with a sensor's white noise, per line of an FFT."""
    power = np.abs(np.fft.rfft(residual - residual.mean())) ** 2
    wide = np.pad(power, SMOOTHED // 2, mode="reflect")
    mean = np.convolve(wide, np.ones(SMOOTHED) / SMOOTHED, "valid")
    return np.asarray(mean[: len(power)] + len(residual) * white**2)


class Yardstick:
    """Noise and tolerances of one drive, against which changes are measured.

    Parameters
    ----------
    family : str
    p : Truth
        The car that the file describes.
    d : Drive
        Drive on a smooth road.
    known : sequence of str
        Toleranced figures that the file states.
    residual : ndarray, shape (rows, columns)
        What a rough road adds to the rows.
    """

    def __init__(
        self, family: str, p: Truth, d: Drive, known: Sequence[str], residual: Array
    ) -> None:
        witnesses = SENSORS[family].keys() - NO_WITNESS[family]
        self.sensors = [s for k, s in SENSORS[family].items() if k in witnesses]
        self.root_S = [
            np.sqrt(spectrum(residual[:, s.place], s.noise)) for s in self.sensors
        ]
        nominal = coarse(p, d, family)
        columns = [
            self.whitened(
                coarse(shifted(p, name, TOLERANCES[name]), d, family) - nominal
            )
            for name in known
        ]
        for s in self.sensors:
            constant = np.zeros_like(nominal)
            constant[:, s.place] = s.bias
            columns.append(self.whitened(constant))
        self.nominal = nominal
        self.T = np.array(columns)
        self.TT = np.einsum("ik,jk->ij", self.T, self.T)

    def whitened(self, change: Array) -> Array:
        """Return a change of the rows as one vector in units of the noise.

        Its squared length is D* S⁻¹ D (Parseval, one-sided lines).
        """
        parts = []
        for s, root in zip(self.sensors, self.root_S, strict=True):
            line = np.sqrt(2.0) * np.fft.rfft(change[:, s.place]) / root
            line[0] /= np.sqrt(2.0)
            parts += [line.real, line.imag]
        return np.concatenate(parts)

    def nats(self, change: Array, others: Sequence[Array] = ()) -> float:
        """Return what a change of the rows is worth beyond the tolerances.

        ``others`` are changes of any size that may stand in for it as well.
        """
        # einsum, as threads of a matrix library cost seconds where other work runs
        D = self.whitened(change)
        free = [self.whitened(o) for o in others]
        rows = [1e3 * f / max(float(np.linalg.norm(f)), 1e-12) for f in free]
        T = np.array([*self.T, *rows])
        n = len(self.T)
        inner = np.eye(len(T))
        inner[:n, :n] += self.TT
        for k in range(n, len(T)):
            dots = np.einsum("ik,k->i", T, T[k])
            inner[k] += dots
            inner[:k, k] = inner[k, :k]
        shadow = np.einsum("ik,k->i", T, D)
        explained = float(shadow @ np.linalg.solve(inner, shadow))
        return 0.5 * (float(np.einsum("k,k->", D, D)) - explained)
