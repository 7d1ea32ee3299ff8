"""All that a script of one's own begins with, by one import.

=======================================  =============================================
:func:`load_vehicle`                     a vehicle by its name, or its file
:func:`parse_cycle`                      a drive cycle by its name, or its file
:func:`compare`, :func:`match`           π groups of two vehicles; what to change
:func:`scale_cycle`                      a cycle at the size of another vehicle
:func:`yaw_inertia`                      by a bifilar pendulum
:func:`damping_and_inertia`              B and J of a motor from a step response
:func:`fit_step`                         the same from a log of one
:func:`fit_coastdown`                    a road load from coast-downs
:func:`simulate`, :class:`LaneChanges`   a vehicle over a cycle
:func:`energy_report`                    where the energy of a trace went
:func:`open_log`                         a log of any format, checked
:func:`gap`, :func:`diagnose`            where model and log part, and by which effect
:func:`write_mended`                     the vehicle's file with what was found
:func:`read_trace`, :func:`write_trace`  columns on one clock, as files
=======================================  =============================================

What cannot be used raises :class:`InputError`, whose text names what was found.
"""

from rcc_sim.analyse.energy import EnergyReport, energy_report
from rcc_sim.analyse.gap import Gap, gap
from rcc_sim.analyse.logged import Logged, open_log
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import Vehicle, load_vehicle
from rcc_sim.diagnose.deliver import write_mended
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.diagnose.run import diagnose
from rcc_sim.errors import InputError
from rcc_sim.identify.bifilar import yaw_inertia
from rcc_sim.identify.coastdown import fit_coastdown
from rcc_sim.identify.step_response import damping_and_inertia, fit_step
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.similitude.match import match
from rcc_sim.similitude.pi import compare
from rcc_sim.simulate.run import LaneChanges, Run, simulate
from rcc_sim.trace import Trace, read_trace, write_trace

__all__ = [
    "Cycle",
    "Diagnosis",
    "EnergyReport",
    "Gap",
    "InputError",
    "LaneChanges",
    "Logged",
    "Run",
    "Trace",
    "Vehicle",
    "compare",
    "damping_and_inertia",
    "diagnose",
    "energy_report",
    "fit_coastdown",
    "fit_step",
    "gap",
    "load_vehicle",
    "match",
    "open_log",
    "parse_cycle",
    "read_trace",
    "scale_cycle",
    "simulate",
    "write_mended",
    "write_trace",
    "yaw_inertia",
]
