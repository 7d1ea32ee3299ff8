"""A stated figure that is far off is named, in one log and in several together."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.fleet.pool import evidence_of
from rcc_sim.diagnose.fleet.pooled import screen
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.diagnose.search.starts import released
from rcc_sim.report.doubts import doubts
from rcc_sim.simulate.run import simulate

KEY = "effects.rolling_resistance.coefficient"
TRUE, STATED = 0.014, {"value": 0.009, "sd": 0.0008}
KNOWN = {"body.mass_kg": {"value": 574.0, "sd": 5.0}}
TOLD = ("time_s", "speed_mps", "battery_voltage_v", "battery_current_a")


@pytest.fixture(scope="module")
def car():
    """A car whose file states a rolling resistance five sds too low."""
    return load_vehicle("twizy").changed(settings={KEY: STATED, **KNOWN})


def driven(car, folder, part):
    """Return a log of its speed, and of its battery, with noise."""
    true = car.changed(settings={KEY: TRUE})
    run = simulate(true, parse_cycle(part), output_rate=10.0).trace
    rng = np.random.default_rng(len(part))
    noise = dict(zip(TOLD, (0.0, 0.01, 0.05, 0.4), strict=True))
    log = {c: run[c] + noise[c] * rng.normal(size=len(run["time_s"])) for c in TOLD}
    path = folder / "log.csv"
    table = np.column_stack(list(log.values()))
    np.savetxt(path, table, delimiter=",", header=",".join(TOLD), comments="")
    return open_log(path, car)


def test_one_log_names_it_or_its_twin(car, tmp_path):
    found = diagnose([driven(car, tmp_path, "udds[350:700]")], car).document()
    assert found["status"] == "explained"
    (cause,) = found["causes"]
    assert "rolling_resistance" in {
        cause["effect"],
        *cause["indistinguishable_from"],
    }


def null_of(log, car):
    """Return the log's engine, its fit by tolerances alone, and the candidates."""
    problem = problem_of(log.log, car)
    engine = Engine([problem])
    null = descent.fit(engine, {}, nuisance_knobs([problem]))
    return engine, null, candidates_for([problem])


def test_a_tolerance_that_was_pulled_far_stands_as_its_own_effect(car, tmp_path):
    engine, null, able = null_of(driven(car, tmp_path, "udds[350:700]"), car)
    (knob,) = (k for k in null.knobs if k.key == KEY)
    pull = (null.values[KEY] - knob.value) / knob.sd
    assert pull > 3
    found = [r for r, _ in released(engine, null, able) if KEY in r.values]
    assert [r.gain for r in found] == [0.5 * pull**2]


def test_several_logs_weigh_it_beside_its_tolerance(car, tmp_path):
    logs = [driven(car, tmp_path, p) for p in ("udds[350:700]", "udds[700:1100]")]
    forms = [evidence_of(*null_of(log, car)) for log in logs]
    one = next(
        p for p in screen({"car": forms}, ()) if p.effect == "rolling_resistance"
    )
    assert one.nats_common > 8.0
    assert one.value == pytest.approx(TRUE, abs=0.001)


def test_the_log_of_another_car_explains_nothing(tmp_path):
    """A small car's drive beside a large car's file: no effect is to blame."""
    other = load_vehicle("tesla_model_3")
    log = driven(load_vehicle("twizy"), tmp_path, "udds[0:400]")
    one = open_log(tmp_path / "log.csv", other)
    assert len(one.log) == len(log.log)
    found = diagnose([one], other)
    assert found.document()["status"] != "explained"
    told = " ".join(what for _, what in doubts(found))
    assert "was it this vehicle that drove?" in told
