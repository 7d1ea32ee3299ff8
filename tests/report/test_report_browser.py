"""The page in a real browser: Chromium, driven by selenium."""

from __future__ import annotations

import re
import shutil
from urllib.parse import quote

import pytest

from rcc_sim.report.html import page
from tests.report.made import NASTY, diagnosis_report

webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not there")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
DRIVER = shutil.which("chromedriver")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.xdist_group("browser"),
    pytest.mark.skipif(
        not (CHROMIUM and DRIVER), reason="no chromium and chromium-driver here"
    ),
]
WIDTHS = (360, 768, 1280, 1920)


@pytest.fixture(scope="module")
def browser():
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for word in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage"):
        options.add_argument(word)
    options.set_capability(
        "goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"}
    )
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(page(diagnosis_report(name=NASTY)), encoding="utf-8")
    return path


@pytest.fixture
def opened(browser, file):
    """Return the browser with the page open, 1280 wide, in light colours."""
    emulate(browser, 1280)
    browser.get_log("browser"), browser.get_log("performance")
    browser.get(f"file://{quote(str(file))}")
    return browser


def emulate(browser, width, *, scheme="light", medium="", script=True):
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    feature = {"name": "prefers-color-scheme", "value": scheme}
    media = {"media": medium, "features": [feature]}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
    off = {"value": not script}
    browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", off)


def lines(browser):
    return [
        e.get_attribute("d") for e in browser.find_elements("css selector", "svg .line")
    ]


def drawn_again(browser):
    """Wait until the charts stand still."""
    browser.execute_async_script(
        "const done = arguments[0];"
        "requestAnimationFrame(() => requestAnimationFrame(() => done()));"
    )


def test_it_opens_without_a_word_on_the_console_and_asks_for_nothing(opened, file):
    ready = opened.find_element("id", "charts").get_attribute("data-ready")
    assert ready == "yes"
    assert opened.get_log("browser") == []
    asked = [
        url
        for entry in opened.get_log("performance")
        for url in re.findall(r'"url":"([^"]+)"', entry["message"])
    ]
    assert asked and {url.partition(":")[0] for url in asked} <= {"file", "about"}
    assert {url for url in asked if url.startswith("file")} == {
        f"file://{quote(str(file))}"
    }


def test_a_request_from_inside_the_page_would_be_refused(opened):
    script = (
        "const done = arguments[0]; fetch('data:text/plain,hello')"
        ".then(() => done('came through'), () => done('refused'));"
    )
    assert opened.execute_async_script(script) == "refused"


def test_a_script_in_a_name_is_text(opened):
    assert NASTY in opened.find_element("tag name", "h1").text
    assert len(opened.find_elements("tag name", "script")) == 2


@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_sticks_out_at_any_width(opened, width):
    emulate(opened, width)
    wide = opened.execute_script("return document.documentElement.scrollWidth")
    assert wide <= width
    out = opened.execute_script(
        "return [...document.querySelectorAll('h1,h2,p,th,td,dd,dt,li,figure,button')]"
        ".filter((e) => !e.closest('pre') && e.getClientRects().length)"
        ".filter((e) => e.getBoundingClientRect().right > innerWidth + 1)"
        ".map((e) => e.outerHTML.slice(0, 120))"
    )
    assert out == []


def test_dragging_across_a_chart_zooms_all_of_them(opened):
    from selenium.webdriver import ActionChains

    before = lines(opened)
    plots = opened.find_elements("css selector", ".plot")
    opened.execute_script("arguments[0].scrollIntoView({block: 'center'})", plots[0])
    wide = plots[0].size["width"]
    chain = ActionChains(opened).move_to_element_with_offset(plots[0], -wide // 4, 0)
    chain.click_and_hold().move_by_offset(wide // 4, 0).release().perform()
    drawn_again(opened)
    after = lines(opened)
    assert all(a != b for a, b in zip(after, before, strict=True) if "L" in b[9:])
    marks = {e.text for e in opened.find_elements("css selector", ".xs")}
    assert len(marks) == 1  # one time axis
    shown = [float(mark) for mark in marks.pop().split()]
    assert 17 <= min(shown) and max(shown) <= 37  # a quarter to a half of 72 s
    opened.find_element("css selector", "[data-do=all]").click()
    drawn_again(opened)
    whole = opened.find_elements("css selector", ".xs")[0].text.split()
    assert (whole[0], float(whole[-1]) >= 60) == ("0", True)


def test_the_keyboard_zooms_and_moves(opened):
    from selenium.webdriver import Keys

    def first_mark():
        drawn_again(opened)
        return float(opened.find_element("css selector", ".xs span").text)

    charts = opened.find_element("id", "charts")
    charts.send_keys("+")
    zoomed = first_mark()
    charts.send_keys(Keys.ARROW_RIGHT)
    assert 0 < zoomed < first_mark()
    charts.send_keys("0")
    assert first_mark() == 0


def test_pointing_tells_all_values_at_one_moment(opened):
    from selenium.webdriver import ActionChains

    plot = opened.find_elements("css selector", ".plot")[0]
    opened.execute_script("arguments[0].scrollIntoView({block: 'center'})", plot)
    ActionChains(opened).move_to_element(plot).perform()
    values = [e.text for e in opened.find_elements("css selector", ".value")]
    assert all(re.match(r"−?[\d.]", v) for v in values) and len(values) > 10
    at = opened.find_element("id", "at").text
    moment, _, regime = at.partition(" s, ")
    assert float(moment) == pytest.approx(36.0, abs=0.2)
    assert regime == "standstill"


def test_a_line_can_be_taken_away_and_brought_back(opened):
    key = opened.find_element("css selector", ".legend button")
    before = lines(opened)[0]
    key.click()
    assert key.get_attribute("aria-pressed") == "false"
    assert lines(opened)[0] == ""
    key.click()
    assert lines(opened)[0] == before


def background(browser):
    return browser.execute_script(
        "return getComputedStyle(document.body).backgroundColor"
    )


def test_the_theme_follows_the_system_and_the_button(opened):
    light = background(opened)
    emulate(opened, 1280, scheme="dark")
    dark = background(opened)
    assert light == "rgb(255, 255, 255)" and dark != light
    opened.find_element("id", "theme").click()
    assert background(opened) == light
    opened.find_element("id", "theme").click()
    emulate(opened, 1280, scheme="light")
    assert background(opened) == dark


def test_it_prints_light_and_without_buttons(opened):
    emulate(opened, 1280, scheme="dark", medium="print")
    assert background(opened) == "rgb(255, 255, 255)"
    assert not any(b.is_displayed() for b in opened.find_elements("id", "theme"))
    printed = opened.execute_cdp_cmd("Page.printToPDF", {"printBackground": False})
    assert len(printed["data"]) > 50_000


def test_without_a_script_text_and_charts_are_there(browser, file):
    emulate(browser, 1280, script=False)
    browser.get(f"file://{quote(str(file))}")
    try:
        tree = browser.execute_cdp_cmd("DOM.getDocument", {"depth": 0})
        found = browser.execute_cdp_cmd(
            "DOM.getOuterHTML", {"nodeId": tree["root"]["nodeId"]}
        )["outerHTML"]
    finally:
        emulate(browser, 1280)
    assert 'data-ready="yes"' not in found
    assert found.count('class="line ') >= 15 and "Coast down from 5 m/s" in found
    assert re.search(r'id="theme"[^>]*hidden', found)
