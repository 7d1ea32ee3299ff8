"""The page: whole without a script, one file, every name shown as text."""

from __future__ import annotations

import dataclasses
import html.parser
import json
import re

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.report.findings import Report
from rcc_sim.report.html import page
from rcc_sim.report.provenance import run_record
from rcc_sim.report.text import escaped, percent, printable, probable, tag
from rcc_sim.report.verdict import verdict_of
from rcc_sim.trace import Trace
from tests.program import rccsim
from tests.report.made import NASTY, diagnosis_report

VOID = {"meta", "br", "hr", "input", "rect", "path"}


class Reader(html.parser.HTMLParser):
    """What a page holds: tags, attributes, and text outside script and style."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.words, self.open = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in VOID - {"rect", "path"}:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not {"script", "style"} & set(self.open):
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def report():
    return diagnosis_report()


@pytest.fixture(scope="module")
def read(report):
    return Reader(page(report))


def test_the_page_is_well_formed_and_loads_nothing(report, read):
    assert read.open == []
    names = {name for name, _ in read.attributes}
    assert not names & {"src", "srcset", "poster", "action", "onclick", "onload"}
    links = [v for n, v in read.attributes if n in ("href", "xlink:href")]
    ids = {v for n, v in read.attributes if n == "id"}
    assert links and all(v[0] == "#" and v[1:] in ids for v in links)
    assert "url(" not in page(report) and "@import" not in page(report)


def test_without_a_script_the_text_says_everything(read):
    for words in (
        "the model misses 15.9 %",
        "rolling resistance",
        "97 %",
        "this log cannot tell them apart",
        "This log cannot tell it from",
        "What gives it away",
        "0.0196 (0.019 to 0.0203)",
        "92 % (90 % interval 89 % to 94 %)",
        "no fit saw",
        "Coast down from 5 m/s in both directions.",
        "One row stands 400 W above its neighbours.",
        "+[effects.rolling_resistance]",
        "unexplained",
        "0" * 64,
        "rccsim 0.1.0",
        "Seed: 0",
        "ISO/TS 18571",
    ):
        assert words in read.text


def test_every_chart_is_told_in_words_too(read):
    told = [v for n, v in read.attributes if n == "aria-label" and "mean" in v]
    assert len(told) == 5
    assert any("measured from" in v and "400" in v for v in told)  # the spike


def test_the_waterfall_adds_up_from_simulated_to_measured(report, read):
    numbers = [
        float(value.replace("−", "-"))
        for value in re.findall(
            r"(?:simulated|resistance or what ties with it|unexplained|measured) "
            r"([+−\d.]+) [\d.]+ %",
            read.text,
        )
    ]
    energy = report.diagnosis["where"]["energy"]
    assert len(numbers) == 4
    assert sum(numbers[:3]) == pytest.approx(numbers[3], abs=2e-4)
    assert numbers[3] == pytest.approx(energy["measured_wh"], rel=1e-3)


@pytest.mark.parametrize("name", [NASTY, "</script><b>x", "a\x1b[31mred", '"><img x='])
def test_a_name_from_a_file_shows_as_text_and_is_never_markup(name):
    report = diagnosis_report(18.0, name)
    weird = {f"{name}_w": report.before["speed_mps"]}
    log = dict(report.measured.columns) | weird
    report = dataclasses.replace(
        report, measured=Trace(log, name=name), before={**report.before, **weird}
    )
    plain, nasty = Reader(page(diagnosis_report(18.0))), Reader(page(report))
    assert " ".join(printable(name).split()) in nasty.text
    assert set(nasty.tags) == set(plain.tags)
    assert nasty.tags.count("script") == 2
    assert "\x1b" not in page(report)


def test_the_same_report_gives_the_same_bytes(report):
    assert page(report) == page(diagnosis_report())


def test_a_page_of_several_logs_says_which_it_draws(report, read):
    which = "a.csv, the first of 2 logs"
    of_two = Reader(page(dataclasses.replace(report, which=which)))
    assert f"Measured against simulated: {which}" in of_two.text
    assert "Measured against simulated:" not in read.text


def test_ten_minutes_at_100_hz_fit_into_6_mb():
    long = diagnosis_report(612.0)
    assert len(long.measured) > 60_000
    extra = {f"c{k}_w": long.before["speed_mps"] for k in range(5)}
    long = dataclasses.replace(
        long,
        before={**long.before, **extra},
        after={**long.after, **extra},
        measured=Trace({**long.measured.columns, **extra}),
    )
    assert len(page(long).encode()) < 6e6  # nine channels, three lines each


def test_hours_of_log_are_thinned_into_6_mb_and_keep_their_spike():
    n = 2_000_000
    time = np.arange(n) / 100.0
    values = np.sin(time)
    values[1_234_567] = 99.0
    log = Trace({"time_s": time, "battery_power_w": values})
    text = page(Report("hours", measured=log, before={"battery_power_w": np.sin(time)}))
    assert len(text.encode()) < 6e6
    data = json.loads(re.search(r'id="data">(.*?)</script>', text)[1])
    line = data["panels"][0]["lines"][0]
    assert line["low"] + 65534 * line["step"] == pytest.approx(99.0)


@pytest.mark.parametrize(
    "part",
    [
        {},
        {"diagnosis": {"where": {}}},
        {"diagnosis": {"status": "no_gap", "causes": []}},
        {"diagnosis": {"status": "unexplained", "shrink": None, "unexplained": None}},
        {"diagnosis": {"where": {"energy": None, "windows": None}, "causes": None}},
    ],
    ids=str,
)
def test_a_page_with_parts_missing_is_still_whole(part):
    read = Reader(page(Report("title", **part)))
    assert read.open == [] and "title" in read.text
    assert "None" not in read.text and "nan" not in read.text


def test_what_hangs_together_is_left_over_though_no_row_is_off(report):
    acts = {"acts_as": "drag", "follows": "since_braking_s"}
    for left, told in (({}, "Nothing beyond noise"), (acts, "hangs together; it acts")):
        one = report.diagnosis | {"unexplained": {"fraction": 0.0, **left}}
        assert told in page(dataclasses.replace(report, diagnosis=one))


def test_what_is_left_of_several_logs_is_told_with_its_log(report):
    when = [{"start_s": 0.0, "end_s": 12.0}]
    left = {"fraction": 0.3, "windows": when, "acts_as": "drag", "log": "<b>.csv"}
    one = report.diagnosis | {"unexplained": left}
    shown = page(dataclasses.replace(report, diagnosis=one))
    assert "most of it at 0 to 12 s, in &lt;b&gt;.csv." in shown


def test_what_is_left_is_left_by_the_mended_vehicle(report):
    """It has the causes, and the stated figures as the log moved them."""
    verdict = verdict_of(report.diagnosis)
    assert verdict.rstrip(".").endswith("once it is mended")
    assert "with the mended vehicle" in page(report)


def test_no_gap_where_no_energy_was_measured_says_what_was_judged():
    channels = [{"channel": c} for c in ("yaw_rate_radps", "battery_voltage_v")]
    where = {"energy": {"measured_wh": None}, "channels": channels}
    verdict = verdict_of({"status": "no_gap", "where": where})
    assert verdict.startswith("No gap in yaw_rate_radps and battery_voltage_v beyond")
    assert verdict.endswith("no energy was judged.")
    where["energy"] = {"measured_wh": 2.0, "simulated_wh": 2.0}
    verdict = verdict_of({"status": "no_gap", "where": where})
    assert verdict.startswith("No gap beyond") and "no energy" not in verdict
    where["energy"] = {"measured_wh": 2.0, "simulated_wh": 1.5, "within": False}
    verdict = verdict_of({"status": "no_gap", "where": where})
    assert "row by row" in verdict and "stated figures take the energy up" in verdict


def test_gap_alone_has_a_verdict_and_its_place(report):
    where = report.diagnosis["where"]
    verdict = verdict_of({"where": where})
    assert (
        "misses 15.9 %" in verdict
        and "+0.0411 Wh of it in cruise, +0.0532 Wh of it in the mechanical" in verdict
    )
    read = Reader(page(Report("gap", diagnosis={"where": where})))
    assert verdict in read.text and "What it is" not in read.text


def test_a_clock_since_1970_is_told_from_the_logs_start(report):
    start = 1.7e9
    late = dataclasses.replace(
        report,
        measured=Trace(
            {
                **report.measured.columns,
                "time_s": report.measured["time_s"] + start,
            }
        ),
        regimes=tuple(
            dataclasses.replace(s, start_s=s.start_s + start, end_s=s.end_s + start)
            for s in report.regimes
        ),
    )
    text = page(late)
    assert "since the log" in text
    shades = re.compile(r'd="([^"]+)" class="shade t')
    assert shades.findall(text) == shades.findall(page(report)) != []


def test_an_element_escapes_what_is_put_into_it():
    assert tag("p", "<b>", title='"') == '<p title="&quot;">&lt;b&gt;</p>'
    assert escaped(tag("b", "x")) == "<b>x</b>"
    assert percent(0.00001) == "< 0.01 %" and percent(0.5) == "50 %"


def test_a_probability_is_never_rounded_up_to_certainty():
    told = [percent(p) for p in (0.995, 0.9999, 1.0, 0.99)]
    assert told == ["99.5 %", "> 99.9 %", "100 %", "99.0 %"]
    assert [probable(p) for p in (0.995, 0.99, None)] == ["> 99 %", "99.0 %", "–"]


def test_what_was_run_has_versions_and_hashes(tmp_path):
    import hashlib

    file = tmp_path / "a.csv"
    file.write_bytes(b"time_s\n")
    record = run_record([file, "-", "rcc"], seed=3)
    first, second, car = record["inputs"]
    assert first["sha256"] == hashlib.sha256(b"time_s\n").hexdigest()
    assert second["sha256"] is None and record["seed"] == 3
    shipped = load_vehicle("rcc").path.read_bytes()
    assert car["sha256"] == hashlib.sha256(shipped).hexdigest()
    assert {"rccsim", "python", "numpy"} <= record["versions"].keys()


def test_energy_writes_a_page_of_its_drives(tmp_path):
    def run(*words):
        return rccsim(*words, cwd=tmp_path)

    for name, more in (("a", ()), ("b", ("--lane-change-every", "20"))):
        drive = ("simulate", "rcc", "--cycle", "udds[20:60]", "--imposed")
        assert run(*drive, *more, "-o", f"{name}.csv").returncode == 0
    done = run("energy", "a.csv", "b.csv", "--html", "energy.html", "--json")
    assert done.returncode == 0, done.stderr
    runs = json.loads(done.stdout)["runs"]
    read = Reader((tmp_path / "energy.html").read_text("utf-8"))
    assert f"{runs[0]['wh_per_km']:.4g}" in read.text
    assert "drivetrain damping" in read.text and "rccsim energy a.csv" in read.text
