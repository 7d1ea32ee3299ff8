"""Stated figures that a log moved are named on the screen: from, to, in their sds."""

from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.fitting.pulls import moved, moved_together
from rcc_sim.diagnose.judge.asserted import Estimate
from rcc_sim.diagnose.run import diagnose
from rcc_sim.diagnose.search.taken import KeptOut
from rcc_sim.report import html_causes
from rcc_sim.report.doubts import differs, doubts, moved_figures, one_parts
from rcc_sim.report.screen import screen
from rcc_sim.report.verdict import verdict_of
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace

STATED = {"body.mass_kg": 3.0, "tyres.radius_m": 0.05, "body.yaw_inertia_kgm2": 0.04}
FIGURES = {key: Figure(x, 0.01 * x) for key, x in STATED.items()}


def fitted(knobs, values):
    """A fit that told as much again of each figure as is stated of it."""
    after = np.diag([2 / k.sd**2 if k.sd < inf else 1.0 for k in knobs])
    return Fit(values, tuple(knobs), 0, 0, [], [], after)


def diagnosed(fit, kept_out=None, status="no_gap"):
    """What of a diagnosis says how far it moved what is stated."""
    return SimpleNamespace(
        status=status,
        taken_up=False,
        kept_out=kept_out,
        vehicle=SimpleNamespace(figures=lambda: FIGURES),
        moved=moved(fit, FIGURES),
        moved_together=moved_together(fit, FIGURES),
    )


def test_the_farthest_come_first_and_those_within_an_sd_are_silent():
    knobs = [Knob(k, v, 0.01 * v) for k, v in STATED.items()]
    knobs += [Knob("effects.payload.mass_kg", 0.0, inf), Knob("bias.0.x", 0.0, 1.0)]
    off = {"body.mass_kg": 3.045, "tyres.radius_m": 0.049, "bias.0.x": 5.0}
    values = {k.key: k.value for k in knobs} | off | {"effects.payload.mass_kg": 1.0}
    fit = fitted(knobs, values)
    told = list(moved_figures(diagnosed(fit)))
    says = "tyres.radius_m 0.05 to 0.049 (−2.0 sd), body.mass_kg 3 to 3.045 (+1.5 sd)"
    assert told == [("MOVED", says)]


@pytest.mark.parametrize(("mass", "says"), [(3.06, False), (3.21, True)])
def test_what_figures_far_off_may_stand_in_for_is_named(mass, says):
    knobs = [Knob(k, v, 0.01 * v) for k, v in STATED.items()]
    fit = fitted(knobs, STATED | {"body.mass_kg": mass})
    kept = KeptOut("payload", {"effects.payload.mass_kg": 0.2}, 67.0, 75.0)
    _, *more = moved_figures(diagnosed(fit, kept))
    why = "may act in place of these shifts: it gains 67 nats, where 75 are asked"
    told = [("DOUBT", f"payload (mass_kg 0.2) {why} beside so strong a cause")]
    assert more == (told if says else [])


@pytest.mark.parametrize(
    ("status", "advice"),
    [
        ("no_gap", "measure it again, or state a larger sd"),
        ("unexplained", "may stand in for what nothing explains: measure it again"),
    ],
)
def test_a_figure_that_moved_beside_what_is_left_is_not_to_be_taken(status, advice):
    """A larger sd would let it move, and a gap go, for something else."""
    knobs = [Knob(k, v, 0.01 * v) for k, v in STATED.items()]
    fit = fitted(knobs, STATED | {"body.mass_kg": 3.12})
    ((word, says),) = moved_figures(diagnosed(fit, status=status))
    assert word == "MOVED" and says.endswith(f"; {advice}")
    if status == "unexplained":
        shown = {"status": status, "moved": moved(fit, FIGURES)}
        assert verdict_of(shown).endswith(f"off what is stated: {advice}.")


def test_where_none_moved_nothing_is_said():
    knobs = [Knob(k, v, 0.01 * v) for k, v in STATED.items()]
    fit = fitted(knobs, STATED)
    assert list(moved_figures(diagnosed(fit))) == []


def test_a_gap_that_what_was_asked_for_does_not_explain_says_so():
    """In the sentence and on the page: nobody asked the library."""
    asked = {"status": "unexplained", "candidates": ["payload", "headwind"]}
    every = {"status": "unexplained", "candidates": []}
    those = "payload or headwind does not account for, and nothing else was asked"
    assert verdict_of(asked).startswith(f"A real gap that {those}")
    assert those in html_causes.asserted(asked)
    for told in (verdict_of(every), html_causes.asserted(every)):
        assert "real gap that no effect of the library accounts for" in told


@pytest.mark.parametrize("within", [True, False, None])
def test_a_gap_whose_energy_is_within_doubt_is_one_of_the_signals(within):
    energy = {"measured_wh": 0.3, "simulated_wh": 0.29, "gap_percent": 3.3}
    where = {"energy": energy | {"within": within}}
    told = verdict_of({"status": "unexplained", "where": where})
    assert ("gap in the course of the signals that no effect" in told) == bool(within)
    assert ("within what noise" in told) == bool(within)


CLOSED = {
    "status": "unexplained",
    "asserted": (),
    "moved": {"tyres.radius_m": 3.0},
    "moved_together": 3.5,
}


@pytest.mark.parametrize(
    ("changed", "taken_up"),
    [
        ({}, True),
        ({"moved": {}}, False),
        ({"moved": {"tyres.radius_m": -8.7}}, False),
        ({"moved_together": 13.0}, False),
        ({"left": SimpleNamespace(is_real=True)}, False),
        ({"status": "no_gap"}, False),
        ({"after": 9.0}, False),
        ({"after": None, "before": None}, False),
        ({"explained": 0.5}, False),
    ],
)
def test_what_stated_figures_take_up_is_a_gap_that_they_close(changed, taken_up):
    proof = {"before": 25.0, "after": 0.3, "explained": 0.99}
    for key in proof.keys() & changed.keys():
        proof[key] = changed[key]
    shrink = SimpleNamespace(explained=proof.pop("explained"))
    stub = CLOSED | {"left": SimpleNamespace(is_real=False)} | changed
    stub["proof"] = SimpleNamespace(shrink=shrink, **proof)
    assert Diagnosis.taken_up.fget(SimpleNamespace(**stub)) is taken_up


def test_no_effect_is_said_to_be_missing_where_stated_figures_close_the_gap():
    shrink = {"energy_gap_percent_before": 25.5, "energy_gap_percent_after": 0.17,
              "held_out": True}  # fmt: skip
    told = verdict_of(
        {
            "status": "unexplained",
            "taken_up": True,
            "shrink": shrink,
            "moved": {"effects.regeneration_limit.max_torque_nm": -3.1},
        }
    )
    assert told.startswith("A real gap, and no effect is needed: stated figures take")
    assert "misses 25.5 %, and misses 0.17 % once it is mended" in told
    assert told.endswith("3.1 sds off what is stated: measure it again, or state a "
                         "larger sd.")  # fmt: skip


def test_what_moved_far_is_doubtful_and_farther_another_vehicle_s():
    says = [verdict_of({"status": "no_gap", "moved": {"body.mass_kg": x}})
            for x in (2.0, -4.0, 30.0)]  # fmt: skip
    assert "body.mass_kg" not in says[0]
    assert says[1].endswith("measure it again, or state a larger sd.")
    assert "30 sds" in says[2] and says[2].endswith("was it this vehicle that drove?")


def test_three_causes_one_at_a_bound_are_another_vehicle_s():
    """A Tesla's log on a pick-up's file: less than nothing carried, no road load."""
    payload = {"mass_kg": {"value": -794.0, "low": -794.0, "high": -511.0}}
    inside = {"mass_kg": {"value": -600.0, "low": -794.0, "high": -511.0}}
    others = [{"effect": e, "parameters": {}} for e in ("road_load", "headwind")]

    def says(figures):
        causes = [{"effect": "payload", "parameters": figures}, *others]
        return verdict_of({"status": "partly_explained", "causes": causes})

    assert "payload at a bound: was it this vehicle that drove?" in says(payload)
    assert "vehicle" not in says(inside)


@pytest.mark.parametrize(
    "low, told",
    [
        (0.97, "100 % of what is beyond noise, on data"),
        (0.2, "100 % of what is beyond noise (20 % at least), on data"),
        (-0.3, "100 % of what is beyond noise, or nothing, on data"),
    ],
)
def test_what_the_held_out_rows_do_not_prove_is_said_in_the_sentence(low, told):
    shrink = {"held_out": True, "explained": 1.0, "low": low, "high": 1.0}
    causes = [{"effect": "aerodynamic_drag", "probability": 0.5, "parameters": {}}]
    said = {"status": "partly_explained", "causes": causes, "shrink": shrink}
    assert told in verdict_of(said)


@pytest.mark.parametrize("high, apart", [(0.01, True), (0.02, False)])
def test_a_mean_that_is_another_in_each_log_is_doubted(high, apart):
    each = Estimate(0.0, 0.0, high, 0.01), Estimate(0.018, 0.017, 0.019, 0.001)
    mean = Estimate(0.009, 0.008, 0.01, 0.001, each=each)
    figures = {"slope": mean, "other": Estimate(1.0, 0.9, 1.1, 0.1)}
    assert differs(SimpleNamespace(figures=figures)) is apart


@pytest.mark.parametrize(
    "within, told",
    [
        ((True, False, True), "of b is beyond its doubt, that of a and c is not: "),
        ((False, *6 * (True,)), "that of b, c, d, e and 2 more is not: "),
        ((True, True), None),
        ((False, False), None),
        ((False, None), None),
    ],
)
def test_logs_that_part_alone_are_named(within, told):
    energies = [SimpleNamespace(within=x) for x in within]
    gaps = [
        SimpleNamespace(log=f"{name}.csv", energy=e)
        for name, e in zip("abcdefg", energies, strict=False)
    ]
    said = [
        text.replace(".csv", "") for _, text in one_parts(SimpleNamespace(gaps=gaps))
    ]
    assert [told in text for text in said] == [True] if told else not said


def test_no_gap_is_doubtful_where_most_of_what_is_left_is_foreseen():
    said = {"status": "no_gap", "mode": "commanded"}
    left = {"speed_mps": 0.9, "motor_current_a": 0.69, "yaw_rate_radps": 0.1}
    says = verdict_of(said | {"foreseen": left})
    assert "69 % of what is left of motor_current_a is foreseen" in says
    calm = left | {"motor_current_a": 0.3}
    assert "foreseen" not in verdict_of(said | {"foreseen": calm})
    imposed = {"status": "no_gap", "mode": "imposed", "foreseen": left}
    assert "foreseen" not in verdict_of(imposed)


def test_a_current_that_wanders_is_doubted_on_the_screen():
    """A drag that comes and goes every half second, in a drive on a wandering floor."""
    car = load_vehicle("rcc")
    cycle = parse_cycle("udds[20:60]").time_s, parse_cycle("udds[20:60]").speed_mps / 10
    rng = np.random.default_rng(3)
    run = simulate(car, Cycle("drive", *cycle), lanes=LaneChanges(every=3.0)).trace
    columns = ("time_s", "speed_mps", "speed_ref_mps", "steer_cmd_rad",
               "yaw_rate_radps", "motor_current_a")  # fmt: skip
    log = {c: run[c] for c in columns}
    for column, size in (("speed_mps", 0.01), ("yaw_rate_radps", 0.02)):
        log[column] = log[column] + size * rng.normal(size=len(run))
    wander = lfilter([1.0], [1.0, -0.97], rng.normal(size=len(run)))
    for noise, doubted in ((rng.normal(size=len(run)), False), (wander, True)):
        current = run["motor_current_a"] + 0.2 * noise
        logged = Trace(log | {"motor_current_a": current}, name="drive")
        found = diagnose([Logged(logged, (), None)], car)
        assert found.status == "no_gap"
        told = [says for word, says in doubts(found) if word == "DOUBT"]
        assert any("motor_current_a is foreseen" in x for x in told) == doubted


def test_many_causes_at_once_ask_whose_log_it_is():
    causes = [{"effect": f"effect_{i}", "probability": 0.9} for i in range(4)]
    says = verdict_of({"status": "explained", "causes": causes})
    assert says.endswith("4 causes at once: was it this vehicle that drove?")
    assert "vehicle" not in verdict_of({"status": "explained", "causes": causes[:3]})


def test_figures_that_moved_together_are_doubtful_though_none_is_alone():
    moved = {"body.mass_kg": -9.0, "tyres.radius_m": 8.0}
    says = verdict_of({"status": "no_gap", "moved": moved, "moved_together": 12.0})
    assert "together as unlikely as one figure 12 sds off" in says
    assert says.endswith("was it this vehicle that drove?")
    says = verdict_of({"status": "no_gap", "moved": moved, "moved_together": 9.9})
    assert says.endswith("measure it again, or state a larger sd.")


def test_a_wrong_vehicle_is_asked_for_and_its_file_is_not_blamed():
    """A scaled car's drive, said to be a car's, whose mass nothing lets go so far."""
    car = load_vehicle("rcc")
    cycle = parse_cycle("udds[20:80]").time_s, parse_cycle("udds[20:80]").speed_mps / 10
    lanes = LaneChanges(every=3.0)
    run = simulate(car, Cycle("drive", *cycle), lanes=lanes, output_rate=25.0).trace
    columns = ("time_s", "speed_mps", "steer_cmd_rad", "yaw_rate_radps",
               "battery_voltage_v", "battery_current_a")  # fmt: skip
    log = Trace({c: run[c] for c in columns}, name="drive")
    found = diagnose([Logged(log, (), None)], load_vehicle("tesla_model_3"))
    assert max(map(abs, found.document()["moved"].values())) > 10
    assert verdict_of(found.document()).endswith("was it this vehicle that drove?")
    verdict = next(line for line in screen(found, 200) if line.startswith("VERDICT"))
    assert verdict.endswith("was it this vehicle that drove?")
