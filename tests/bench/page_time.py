"""Time until a page can be used: first paint, ready, interactive, and the processor time of its thread until then.

`python tests/bench/page_time.py PAGE... [--rounds N]`, with pages that `flexsat report`, `paper` or `campaign` wrote.
Each is opened in Chromium, anew in each round, without network, at 1400 px; the round with the least time counts, as
other work disturbs the clock. Interactive is the end of the last task above 50 ms of the page's thread, after the first
paint and before 2 s of quiet, or when the page has drawn its plots (`data-ready`), whichever is later. The processor
time is that of tasks of the thread, which the load of the machine hardly changes. Nothing passes or fails here; the aim
is 1.5 s.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent))

from browser_pages import WIDE, chromium  # noqa: E402

AIM = 1500.0  # ms
QUIET = 2000  # ms without a long task
WATCH = """() => {
  window.longTasks = [];
  new PerformanceObserver((list) => {
    for (const one of list.getEntries()) longTasks.push([one.startTime, one.startTime + one.duration]);
  }).observe({ type: "longtask", buffered: true });
  new MutationObserver(() => {
    if (document.documentElement?.dataset.ready && !window.readyAt) window.readyAt = performance.now();
  }).observe(document, { attributes: true, subtree: true });
}"""
READ = """() => {
  const [opened] = performance.getEntriesByType("navigation");
  const paint = performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? 0;
  const last = Math.max(0, ...longTasks.filter(([, end]) => end > paint).map(([, end]) => end));
  return { paint, parsed: opened.domInteractive, ready: readyAt, interactive: Math.max(last, readyAt),
    longest: Math.max(0, ...longTasks.map(([start, end]) => end - start)),
    elements: document.querySelectorAll("*").length };
}"""


def measure(browser: Any, path: Path) -> dict[str, float]:
    """Open a page and return its times [ms]."""
    page = browser.new_page(viewport=WIDE)
    page.add_init_script(f"({WATCH})()")
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})
    page.goto(path.resolve().as_uri(), wait_until="load")
    page.wait_for_selector("html[data-ready]", state="attached", timeout=120_000)
    page.wait_for_function(
        f"() => performance.now() - Math.max(readyAt, ...longTasks.map(([, end]) => end)) > {QUIET}", timeout=120_000
    )
    found: dict[str, float] = page.evaluate(READ)
    counted = {one["name"]: one["value"] for one in session.send("Performance.getMetrics")["metrics"]}
    page.close()
    return found | {"tasks": 1e3 * counted["TaskDuration"], "script": 1e3 * counted["ScriptDuration"]}


def main() -> None:
    """Measure the pages and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", type=Path, nargs="+", metavar="PAGE")
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    for path in given.pages:
        if not path.is_file():
            parser.error(f"{path}: no such page; `flexsat report` writes one")
    names = ("MB", "elements", "paint", "parsed", "ready", "interactive", "longest", "tasks", "script")
    print(f"{'page; times in ms, tasks and script of the processor':54}" + "".join(f"{name:>12}" for name in names))
    with chromium() as browser:
        for path in given.pages:
            best = min((measure(browser, path) for _ in range(given.rounds)), key=lambda one: one["interactive"])
            values = (path.stat().st_size / 1e6, *(best[name] for name in names[1:]))
            verdict = "within" if best["interactive"] <= AIM else "above"
            print(f"{str(path)[-54:]:54}" + "".join(f"{value:12.4g}" for value in values), f"  {verdict} {AIM:g} ms")


if __name__ == "__main__":
    main()
