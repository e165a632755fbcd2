"""Print a page as PDF with a browser of this machine, Chromium or a relative; no network is used."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from lockstep import InputError

BROWSERS = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "msedge",
)
PRINT_TIMEOUT = 120.0  # s


def find_browser() -> str:
    """Return the path of a browser that prints without a window; raise InputError if there is none."""
    for name in BROWSERS:
        if path := shutil.which(name):
            return path
    raise InputError("--pdf: found no Chromium, Chrome or Edge; install chromium, or print the page from a browser")


def print_pdf(page: Path, out: Path) -> Path:
    """Print a page and return `out`.

    Raises
    ------
    InputError
        If no such browser is installed, or it does not print.
    """
    browser = find_browser()
    with tempfile.TemporaryDirectory() as profile:
        command = [
            browser, "--headless", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
            f"--user-data-dir={profile}", "--no-pdf-header-footer", "--force-device-scale-factor=2",
            "--virtual-time-budget=5000", f"--print-to-pdf={out}",
        ]  # fmt: skip
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            command.append("--no-sandbox")  # Chromium refuses to run as root with a sandbox
        try:
            done = subprocess.run(
                [*command, page.resolve().as_uri()], capture_output=True, text=True, check=False, timeout=PRINT_TIMEOUT
            )
        except subprocess.TimeoutExpired:
            raise InputError(
                f"--pdf: {browser} did not print within {PRINT_TIMEOUT:g} s; print the page from a browser"
            ) from None
    if not out.is_file():
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise InputError(f"--pdf: {browser} did not print ({last}); print the page from a browser")
    return out
