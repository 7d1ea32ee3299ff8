"""Take the README's picture again: `python docs/picture.py` (needs chromium, selenium).

The report of the diagnosis of `rccsim demo`, as a browser shows it.
"""

from __future__ import annotations

import base64
import shutil
import tempfile
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.chrome.service import Service

from rcc_sim.report.demo import run_demo

WIDTH, HEIGHT = 1100, 1010
PICTURE = Path(__file__).resolve().parent / "report.png"


def main() -> None:
    """Write docs/report.png."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or ""
    for word in ("--headless=new", "--no-sandbox", f"--window-size={WIDTH},{HEIGHT}"):
        options.add_argument(word)
    service = Service(shutil.which("chromedriver"))
    with tempfile.TemporaryDirectory() as folder:
        page = run_demo(Path(folder), lambda told: None).files[-1]
        browser = webdriver.Chrome(options=options, service=service)
        browser.get(page.as_uri())
        clip = {"x": 0, "y": 0, "width": WIDTH, "height": HEIGHT, "scale": 1}
        shot = browser.execute_cdp_cmd(
            "Page.captureScreenshot", {"captureBeyondViewport": True, "clip": clip}
        )
        browser.quit()
    PICTURE.write_bytes(base64.b64decode(shot["data"]))


if __name__ == "__main__":
    main()
