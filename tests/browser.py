"""Headless Chromium for tests, driven by Selenium; nothing is ever fetched from a network."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

FLAGS = (
    "--headless=new",
    "--no-sandbox",  # which root may not use
    "--disable-gpu",
    "--enable-unsafe-swiftshader",  # WebGL drawn by software
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1100,800",
    "--force-device-scale-factor=0.5",  # a quarter of the pixels to draw
)


def programs() -> tuple[str, str]:
    """Paths of Chromium and its driver; without them the test is skipped.

    Under CI=true that is a failure where they could be installed.
    """
    found = shutil.which("chromium"), shutil.which("chromedriver")
    if None in found:
        if os.environ.get("CI") == "true" and _can_install():
            pytest.fail("chromium and chromedriver are needed under CI=true")
        pytest.skip("chromium or chromedriver is not installed")
    return found


def _can_install() -> bool:
    if shutil.which("apt-get") is None:
        return False
    sudo = ["sudo", "-n", "true"]
    return os.geteuid() == 0 or (
        shutil.which("sudo") is not None and subprocess.run(sudo, check=False).returncode == 0
    )


class Browser:
    """A page in Chromium."""

    def __init__(self, driver: webdriver.Chrome):
        self.driver = driver
        self.said: list[tuple[str, str]] = []
        self.requests: set[str] = set()

    def open(self, path: Path) -> None:
        """Open a file and wait until the report is ready."""
        self.listen()
        self.said.clear()
        self.requests.clear()
        self.driver.get(path.resolve().as_uri())
        ready = self.wait("report.ready.then(() => done(true), (e) => done(String(e)))")
        assert ready is True, ready

    def run(self, script: str):
        """What a piece of JavaScript returns."""
        return self.driver.execute_script(script)

    def wait(self, script: str):
        """What a piece of JavaScript hands to `done`, whenever it does."""
        return self.driver.execute_async_script(f"const done = arguments[0]; {script}")

    def listen(self) -> None:
        """Collect what the console said and what was asked for."""
        for line in self.driver.get_log("browser"):
            self.said.append((line["level"], line["message"]))
        for line in self.driver.get_log("performance"):
            event = json.loads(line["message"])["message"]
            if event["method"] == "Network.requestWillBeSent":
                self.requests.add(event["params"]["request"]["url"])

    def complaints(self) -> list[tuple[str, str]]:
        """What the console said, but for the speed of software WebGL."""
        self.listen()
        return [s for s in self.said if "GL Driver Message" not in s[1]]

    def strange_requests(self) -> set[str]:
        """What was asked for from outside of the page; not the browser's own pages."""
        self.listen()
        own = ("file:", "data:", "blob:", "chrome:", "chrome-untrusted:", "about:")
        return {url for url in self.requests if not url.startswith(own)}


@contextmanager
def open_browser(folder: Path) -> Iterator[Browser]:
    """Start Chromium with an empty profile in `folder`."""
    chromium, driver = programs()
    options = Options()
    options.binary_location = chromium
    for flag in (*FLAGS, f"--user-data-dir={folder}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    started = webdriver.Chrome(options=options, service=Service(driver))
    started.set_script_timeout(60)
    try:
        yield Browser(started)
    finally:
        started.quit()
