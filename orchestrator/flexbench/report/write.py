"""Put a page together and write it, complete or not at all."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from html import escape
from importlib import resources
from pathlib import Path
from typing import Any

from flexbench.html.document import Block, Listing, body_html
from lockstep import InputError

from .collect import Content, Window, collect
from .gather import Result, gather
from .pdf import find_browser, print_pdf
from .pictures import Image, drawn_images, image_of, stored_images, within_room
from .scene import geometry
from .study import study_folders, study_table
from .study_sections import study_sections
from .tables import described, events, facts, numbers, provenance, scenario_of, system

PAGE = "report.html"
SCRIPTS = ("data.js", "axes.js", "plots.js", "scene.js")
FIRST_PANELS = ("pointing error", "deformation", "rate error", "wheel effort")
MOST_FIRST_PANELS = 4
MOST_SHOWN = 4  # runs in a plot until the reader asks for more


def write_report(
    paths: Sequence[Path],
    out: Path | None = None,
    pdf: bool = False,
    studies: Sequence[Path] = (),
    window: Window | None = None,
) -> list[Path]:
    """Write one page of all runs in the given folders; return what was written.

    Parameters
    ----------
    paths : results folders of runs, or folders of such folders; several are compared
    out : page to write; None for report.html in the first folder
    pdf : print the page to PDF too, beside it
    studies : folders with the table of a study and its figures, besides those among the paths
    window : part of the time to plot and to show in motion, begin and end [s]; a short one is kept row by row

    Raises
    ------
    InputError
        If a folder holds no run, the page cannot be written, or PDF is asked for and no browser is there to print it.
    """
    paths = [Path(path) for path in paths]
    results = gather(paths)
    studies = [*studies, *study_folders(paths)]
    out = out or paths[0] / PAGE
    if out.is_dir():
        raise InputError(f"{out}: is a folder; give a file, for example {out / PAGE}")
    if pdf:
        find_browser()  # before the work
    page = page_of(results, studies, window)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{out.name}-", dir=out.parent) as partial:
            file = Path(partial) / PAGE
            file.write_text(page, encoding="utf-8")
            printed = print_pdf(file, Path(partial) / "report.pdf") if pdf else None
            file.replace(out)
            if printed is None:
                return [out]
            beside = out.with_suffix(".pdf")
            printed.replace(beside)
            return [out, beside]
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror or error}); choose another file") from None


def page_of(results: Sequence[Result], studies: Sequence[Path] = (), window: Window | None = None) -> str:
    """Return the page of some runs."""
    contents = [collect(result, len(results), window) for result in results]
    title = results[0].name if len(results) == 1 else f"{len(results)} runs compared"
    if len(results) > 1 and len(studies) == 1:
        title = f"{studies[0].resolve().name}: {title}"
    told, data = _for_script(title, contents)
    sections: list[tuple[str, str, str]] = [("summary", "Summary", _html(facts(contents)))]
    for study in studies:
        sections.append(("study", "The study's table", _html(study_table(study))))
    found = numbers(contents, with_metrics=not studies)
    if found:
        sections.append(("numbers", "Numbers", _html(found)))
    sections.append(("histories", "Time histories", _part("histories.html") + _left_out(contents)))
    if any(content.told["motion"] for content in contents):
        sections.append(("structure", "The structure in motion", _part("scene.html")))
    images = [image for folder in [*studies, *(r.folder for r in results)] for image in stored_images(folder)]
    taken, left = within_room(images or drawn_images(results))
    if taken or left:
        sections.append(("figures", "Figures", _figures(taken, left)))
    for name, blocks in study_sections(results):
        sections.append((name.lower().replace(" ", "-"), name, _html(blocks)))
    sections.append(("events", "Events and faults", _html(events(results))))
    sections.append(("system", "System", _per_run(results, system)))
    sections.append(("versions", "Versions and hashes", _per_run(results, provenance)))
    return _shell(title, contents, sections, told, data)


def _for_script(title: str, contents: Sequence[Content]) -> tuple[dict[str, Any], list[str]]:
    """Return what the script is told, and the data elements it refers to by id."""
    data: list[str] = []

    def keep(text: str) -> str:
        data.append(text)
        return f"d{len(data) - 1}"

    runs, shown = [], {}
    shown_runs = _shown_first([content.result for content in contents])
    for content in contents:
        parts = []
        for part in content.told["parts"]:
            told = [one | ({"id": keep(text)} if text else {}) for one, text in
                    zip(part["histories"], part["data"], strict=True)]  # fmt: skip
            parts.append({"time": part["time"], "histories": told})
        motion = content.told["motion"]
        if motion is not None:
            shown[motion["configuration"]] = geometry(motion["configuration"])
            motion = motion | {key: keep(motion[key]) for key in ("modal", "torque", "error") if motion.get(key)}
        runs.append(
            {
                "name": content.told["name"],
                "marks": content.told["marks"],
                "parts": parts,
                "motion": motion,
                "shown": content.result.name in shown_runs,
            }
        )
    groups = list(dict.fromkeys(one["group"] for run in runs for part in run["parts"] for one in part["histories"]))
    panels = list(dict.fromkeys([*(name for name in FIRST_PANELS if name in groups), *groups]))[:MOST_FIRST_PANELS]
    return {"title": title, "runs": runs, "geometry": shown, "panels": panels}, data


def _shown_first(results: Sequence[Result]) -> set[str]:
    """Return the runs whose lines show from the start: all of a few, else those of one scenario and variant."""
    if len(results) <= MOST_SHOWN:
        return {result.name for result in results}
    kinds = [(scenario_of(r), r.run is None or r.run.as_published) for r in results]
    preferred = next((kind for kind in (("slew", False), ("fine_pointing", False)) if kind in kinds), kinds[0])
    alike = [result.name for result, kind in zip(results, kinds, strict=True) if kind == preferred]
    return set(alike[:MOST_SHOWN])


def _html(blocks: Sequence[Block]) -> str:
    """Write blocks; a picture as an image, a listing folded away."""
    parts: list[str] = []
    for block in blocks:
        if isinstance(block, Listing):
            parts.append(f"<details><summary>show</summary>{body_html([block])}</details>")
        else:
            parts.append(body_html([block], lambda picture: image_of(picture).html))
    return "\n".join(parts)


def _per_run(results: Sequence[Result], told: Any) -> str:
    """Write the same of every run: side by side would be too wide, so folded away when there are several."""
    if len(results) == 1:
        return _html(told(results[0]))
    return "\n".join(
        f"<details><summary>{escape(result.name)}</summary>{_html(told(result))}</details>" for result in results
    )


def _figures(taken: Sequence[Image], left: Sequence[Image]) -> str:
    html = "\n".join(image.html for image in taken)
    if left:
        html += f'<p class="note">Too large for this page: {escape(", ".join(image.title for image in left))}.</p>'
    return html


def _left_out(contents: Sequence[Content]) -> str:
    """Tell how finely histories are kept, and what found no room."""
    notes = []
    for content in contents:
        for part in content.told["parts"]:
            stride = part["time"]["stride"]
            if stride > 1 and part["histories"]:
                names = ", ".join(dict.fromkeys(one["group"] for one in part["histories"]))
                notes.append(
                    f"{content.told['name']}: the least and the largest value of every"
                    f" {stride * content.interval:.3g} s, so that no peak is lost, of {names}"
                )
            if part["left_out"]:
                notes.append(f"{content.told['name']}: no room on this page for {', '.join(part['left_out'])}")
    if not notes:
        return '<p class="note">Every recorded row is on this page, in single precision.</p>'
    text = "".join(f"<li>{escape(note)}</li>" for note in notes)
    return (
        "<details><summary>How finely these are kept</summary><p class='note'>All others are kept row by row, in"
        " single precision; of a part of the time all are: <code>flexsat report --window FROM TO</code>.</p>"
        f"<ul class='note'>{text}</ul></details>"
    )


def _part(name: str) -> str:
    return resources.files(__package__).joinpath("page", name).read_text(encoding="utf-8")


def _shell(
    title: str,
    contents: Sequence[Content],
    sections: Sequence[tuple[str, str, str]],
    told: dict[str, Any],
    data: Sequence[str],
) -> str:
    results = [content.result for content in contents]
    statuses = [str(result.manifest.get("status", "")) for result in results]
    marks = (
        "".join(
            f' <span class="status{"" if status == "completed" else " bad"}">{escape(status)}</span>'
            for status in statuses[:1]
        )
        if len(results) == 1
        else ""
    )
    names = ", ".join(result.name for result in results) if 1 < len(results) <= MOST_SHOWN else ""
    if len(results) == 1:
        names = described(contents[0])
    links = "".join(f'<a href="#{anchor}">{escape(name)}</a>' for anchor, name, _ in sections)
    body = "\n".join(f'<section id="{a}"><h2>{escape(name)}</h2>\n{html}\n</section>' for a, name, html in sections)
    content = json.dumps(told, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")
    elements = "\n".join(f'<script type="text/plain" id="d{k}">{text}</script>' for k, text in enumerate(data))
    script = "\n".join(_part(name) for name in SCRIPTS)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="flexsat report">
<link rel="icon" href="data:,">
<title>{escape(title)}</title>
<style>
{_part("style.css")}</style>
</head>
<body>
<header><h1>{escape(title)}{marks}</h1><p>{escape(names)}</p></header>
<nav>{links}</nav>
<main>
{body}
</main>
<script type="application/json" id="contents">{content}</script>
{elements}
<script>
"use strict";
(() => {{
{script}
}})();
</script>
</body>
</html>
"""
