"""Which unmodelled effect parts simulation and reality, how much, and how sure.

:mod:`~rcc_sim.diagnose.run` is the whole way in one page. Below it, each floor built on
those under it alone:

==========================================  ============================================
:mod:`~rcc_sim.diagnose.deliver`            what is written: mended vehicle, profiles
:mod:`~rcc_sim.diagnose.diagnosis`          what was found, as JSON
:mod:`~rcc_sim.diagnose.next_run`           which experiment settles what is left
:mod:`~rcc_sim.diagnose.fleet`              many logs, one evidence
:mod:`~rcc_sim.diagnose.proof`              does the gap shrink where no fit looked
:mod:`~rcc_sim.diagnose.judge`              what is asserted, tied, in doubt
:mod:`~rcc_sim.diagnose.search`             which effects: the competition
:mod:`~rcc_sim.diagnose.profiles`           what varies over the drive; the remainder
:mod:`~rcc_sim.diagnose.causes`             effects as candidates, and as causes
:mod:`~rcc_sim.diagnose.fitting`            how much: the likeliest figures
:mod:`~rcc_sim.diagnose.noise`              how likely a residual is
:mod:`~rcc_sim.diagnose.residuals`          a log less the model's replay of it
==========================================  ============================================
"""
