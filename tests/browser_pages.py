"""What tests of pages in a browser share: the browser, sizes of screens, and scripts that look for faults of layout."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
WIDE, PHONE = {"width": 1400, "height": 900}, {"width": 400, "height": 800}
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="no chromium here; `apt-get install chromium` on Debian")

# what lies on other text by more than two pixels, and text that its own box cuts off: of elements without children
FAULTS = """() => {
  const found = [], boxes = [];
  for (const one of document.querySelectorAll("body *")) {
    if (one.closest("svg") || one.children.length || !one.textContent.trim() || !one.checkVisibility?.()) continue;
    if (["SCRIPT", "STYLE", "OPTION"].includes(one.tagName)) continue;
    const style = getComputedStyle(one);
    if (style.overflowX !== "visible" && style.overflowX !== "auto" && one.scrollWidth > one.clientWidth + 1)
      found.push(`cut off: ${one.textContent}`);
    let { left, right, top, bottom } = one.getBoundingClientRect();
    for (let box = one.parentElement; box; box = box.parentElement) {  // what a scrolled box hides is not there
      if (getComputedStyle(box).overflowX === "visible") continue;
      const inside = box.getBoundingClientRect();
      [left, right] = [Math.max(left, inside.left), Math.min(right, inside.right)];
      [top, bottom] = [Math.max(top, inside.top), Math.min(bottom, inside.bottom)];
    }
    if (right - left > 2 && bottom - top > 2) boxes.push({ one, left, right, top, bottom });
  }
  boxes.sort((a, b) => a.top - b.top);
  boxes.forEach((a, k) => {
    for (let n = k + 1; n < boxes.length && boxes[n].top < a.bottom - 2; n++) {
      const b = boxes[n];
      if (a.one.closest("nav") || b.one.closest("nav")) continue;  // it stays above the page
      if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2)
        found.push(`overlap: ${a.one.textContent} / ${b.one.textContent}`);
    }
  });
  return found;
}"""
# records the boxes of what is written on canvases, of their last drawing, before the page's own script starts
WATCH_CANVASES = """() => {
  const pen = CanvasRenderingContext2D.prototype, { fillText, setTransform } = pen;
  window.written = new Map();
  pen.setTransform = function (...numbers) { written.set(this.canvas, []); return setTransform.apply(this, numbers); };
  pen.fillText = function (text, x, y) {
    const size = this.measureText(text);
    written.get(this.canvas)?.push({ text, left: x - size.actualBoundingBoxLeft, right: x + size.actualBoundingBoxRight,
      top: y - size.actualBoundingBoxAscent, bottom: y + size.actualBoundingBoxDescent });
    return fillText.apply(this, arguments);
  };
  window.decoded = 0;
  const { atob } = window;
  window.atob = (text) => { window.decoded += text.length; return atob(text); };
}"""
CANVAS_FAULTS = """() => {
  const found = [];
  for (const [canvas, boxes] of written) {
    if (!canvas.isConnected) continue;
    boxes.forEach((a, k) => {
      if (a.left < -1 || a.right > canvas.clientWidth + 1 || a.top < -1 || a.bottom > canvas.clientHeight + 1)
        found.push(`cut off: ${a.text}`);
      for (const b of boxes.slice(k + 1)) {
        if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
            && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1) found.push(`overlap: ${a.text} / ${b.text}`);
      }
    });
  }
  return found;
}"""


@contextmanager
def chromium() -> Iterator[Any]:
    """Start Debian's Chromium; playwright drives it and downloads nothing."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        options = ["--no-sandbox"] if os.geteuid() == 0 else []
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        yield started
        started.close()


def settle(page: Any) -> None:
    """Wait until the page has drawn what was requested."""
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def ink(condition: str) -> str:
    """Return a script that counts the pixels of a canvas that fulfil a condition on red, green, blue and alpha."""
    return f"""canvas => {{
  const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {{
    const [red, green, blue, alpha] = data.subarray(i, i + 4);
    count += {condition};
  }}
  return count;
}}"""
