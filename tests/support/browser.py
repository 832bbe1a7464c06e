"""A browser without a window, for pages that the product writes."""

from __future__ import annotations

import contextlib
import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

_PATIENCE = 60.0
# 3D is drawn in software: test machines have no graphics card. Nothing may reach for a network.
_FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--force-device-scale-factor=1",
    "--window-size=1280,800",
)


def _program(*names: str) -> str:
    found = next((path for path in map(shutil.which, names) if path), None)
    if found is None:
        pytest.fail(
            f"{names[0]} is not installed, so the report's page cannot be tried; "
            "on Debian and Ubuntu: apt-get install chromium chromium-driver",
            pytrace=False,
        )
    return found


@contextlib.contextmanager
def browser(profile: Path, *more: str) -> Iterator[Page]:
    """Start Chromium with an empty profile, and end it."""
    options = webdriver.ChromeOptions()
    options.binary_location = _program("chromium", "chromium-browser")
    for flag in (*_FLAGS, *more, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(_program("chromedriver")))
    try:
        driver.set_script_timeout(_PATIENCE)
        yield Page(driver)
    finally:
        driver.quit()


class Page:
    """A page in the browser."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver

    def open(self, path: Path, fragment: str = "") -> None:
        """Open a report and wait until it says that it is ready."""
        self.driver.get("about:blank")
        self.driver.get_log("browser")
        self.driver.get(f"{path.as_uri()}{fragment}")
        self.wait("document.documentElement.dataset.ready === 'true'")

    def run(self, code: str, *arguments: Any) -> Any:
        """Run code in the page and return what it returns."""
        return self.driver.execute_script(code, *arguments)

    def value(self, expression: str) -> Any:
        """Return the value of an expression."""
        return self.run(f"return {expression};")

    def wait(self, condition: str) -> None:
        """Wait until a condition holds."""
        end = time.monotonic() + _PATIENCE
        while not self.value(condition):
            assert time.monotonic() < end, f"never true: {condition}"
            time.sleep(0.05)

    def text(self, selector: str) -> str:
        """Return the text of an element."""
        return str(self.run("return document.querySelector(arguments[0]).textContent", selector))

    def click(self, x: float, y: float) -> None:
        """Click at a place of the window, pixels, as a mouse does."""
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            event = {
                "type": kind,
                "x": x,
                "y": y,
                "clickCount": 1,
                "button": "none" if kind == "mouseMoved" else "left",
            }
            self.driver.execute_cdp_cmd("Input.dispatchMouseEvent", event)

    def move(self, x: float, y: float) -> None:
        """Move the mouse to a place of the window, pixels."""
        self.driver.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": "mouseMoved", "x": x, "y": y})

    def drag(self, begin: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag with the left button from one place of the window to another, pixels."""
        for kind, (x, y) in (("mousePressed", begin), ("mouseMoved", end), ("mouseReleased", end)):
            event = {"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1}
            self.driver.execute_cdp_cmd("Input.dispatchMouseEvent", event)

    def choose(self, identifier: str, option: str) -> None:
        """Choose an option of a list."""
        self.run(
            "const box = document.getElementById(arguments[0]); box.value = arguments[1];"
            " box.dispatchEvent(new Event('change'));",
            identifier,
            option,
        )

    def troubles(self) -> list[str]:
        """Return warnings and errors of the console since the page was opened."""
        return [
            entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")
        ]


# What drawing in software says about itself.
_HARMLESS = re.compile(r"GPU stall due to ReadPixels|GL Driver Message|software WebGL", re.IGNORECASE)


def troubles(page: Page) -> list[str]:
    return [line for line in page.troubles() if not _HARMLESS.search(line)]
