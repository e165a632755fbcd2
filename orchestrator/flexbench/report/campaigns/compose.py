"""Compose the page of a campaign: its sections in order, rendered by the templates in `page/`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from flexbench.campaign.samples import CampaignResults, load_bands
from flexbench.campaign.statistics.evaluation import Evaluation, evaluate
from flexbench.campaign.statistics.sensitivities import sobol
from flexbench.campaign.statistics.tables import (
    answer,
    correlation_table,
    metric_table,
    percentile_table,
    requirement_table,
    sampling_note,
    sobol_table,
    worst_table,
)
from flexbench.html.document import Block, Heading, Paragraph, Table
from flexbench.html.page_parts import PageSection, render_page
from lockstep import InputError

from .page_data import MOST_RUNS, bands_data, inputs_that_fit, shown_inputs, systems_data

PAGE_FOLDER = Path(__file__).with_name("page")
SCRIPTS = ("palette.js", "table_of_runs.js", "distributions.js", "matrix.js", "bands.js", "start.js")
_SHOWN_WORST = 10


def evaluations(results: CampaignResults) -> list[Evaluation]:
    """Return the evaluation of each system of a campaign."""
    return [evaluate(sample, results.metrics, results.requirements) for sample in results.samples]


def compose_page(results: CampaignResults, found: Sequence[Evaluation]) -> str:
    """Return the page of a campaign as HTML."""
    data: list[str] = []

    def element(text: str) -> str:
        data.append(text)
        return f"d{len(data) - 1}"

    inputs = inputs_that_fit(found)
    systems = systems_data(found, inputs, element)
    bands, left_out = bands_data(load_bands(results.folder), element)
    units = {"name": results.name, "systems": systems, "bands": bands}
    return render_page(
        title=f"Campaign {results.name}",
        subtitle=_subtitle(results),
        sections=list(_sections(results, found, inputs, bool(bands), left_out)),
        contents=units,
        data=data,
        scripts=[PAGE_FOLDER / name for name in SCRIPTS],
        styles=[PAGE_FOLDER / "campaign.css"],
        folder=PAGE_FOLDER,
    )


def _subtitle(results: CampaignResults) -> str:
    content = results.content
    runs = sum(len(sample) for sample in results.samples)
    parts = [f"{runs} runs", " and ".join(sample.system for sample in results.samples)]
    if content.get("stop_time"):
        parts.append(f"{content['stop_time']:g} s each")
    if content.get("sampling"):
        parts.append(f"{content['sampling']} sampling, seed {content.get('seed', '-')}")
    return ", ".join(parts)


def _sections(
    results: CampaignResults, found: Sequence[Evaluation], inputs: int | None, has_bands: bool, left_out: Sequence[str]
) -> Iterator[PageSection]:
    yield PageSection(anchor="summary", title="Summary", blocks=list(_summary(results, found)))
    if results.requirements:
        yield PageSection(anchor="requirements", title="Requirements", blocks=_requirements(found))
    notes = [
        "Bounds are those of 95 % confidence. Those of percentiles are order statistics and hold for any distribution;"
        " those of the mean are Student's. A failed run has the worst value in percentiles and is not in the mean.",
    ]
    if any(len(one.sample) > MOST_RUNS for one in found):
        notes.append(f"Plots show {MOST_RUNS} runs of each system, evenly spaced by number, with the ends of each"
                     " metric; tables are those of all runs.")  # fmt: skip
    yield PageSection(anchor="metrics", title="Metrics", template="metrics_section.html",
                  blocks=[_table(metric_table(found)), _table(percentile_table(found))], notes=notes)  # fmt: skip
    yield PageSection(anchor="worst", title="Worst runs", blocks=list(_worst(results, found)))
    count = len(shown_inputs(found[0], None))
    shown = () if inputs is None else (f"{inputs} of {count} inputs found room on this page: those that metrics depend"
                                       " on most.",)  # fmt: skip
    yield PageSection(anchor="matrix", title="Scatter matrix", template="matrix_section.html", notes=shown)
    sensitivity = list(_sensitivities(results, found))
    if sensitivity:
        yield PageSection(anchor="sensitivities", title="Sensitivities", blocks=sensitivity)
    if has_bands:
        notes = [f"No room on this page for {', '.join(left_out)}."] if left_out else []
        yield PageSection(
            anchor="bands", title="Time histories of all runs", template="bands_section.html", notes=notes
        )
    yield PageSection(anchor="flown", title="What was simulated", blocks=list(_flown(results)))


def _summary(results: CampaignResults, found: Sequence[Evaluation]) -> Iterator[Block]:
    yield from (Paragraph(text) for text in answer(found))
    if note := sampling_note(str(results.content.get("sampling", ""))):
        yield Paragraph(note)


def _table(table: tuple[list[str], list[list[str]]], code: frozenset[int] = frozenset()) -> Table:
    return Table(*table, code=code)


def _requirements(found: Sequence[Evaluation]) -> list[Block]:
    confidences = sorted({judged.requirement.confidence for one in found for judged in one.judgements})
    return [
        _table(requirement_table(found)),
        Paragraph(
            f"Bounds of the probability after Clopper and Pearson, {' or '.join(f'{100 * c:g} %' for c in confidences)}"
            " confidence: `shown` where the lower bound reaches the required probability, `not met` where the upper"
            " bound does not, `open` between, with the number of runs that would show it at the present share of"
            " failures. A failed run does not meet a requirement."
        ),
    ]


def _worst(results: CampaignResults, found: Sequence[Evaluation]) -> Iterator[Block]:
    for one in found:
        for k, metric in enumerate(one.metrics):
            where = f", {one.sample.system}" if len(found) > 1 else ""
            yield Heading(3, f"{metric.name}{where}")
            yield _table(worst_table(one, k, _SHOWN_WORST))
    yield Paragraph(f"`flexsat campaign rerun {results.folder.name} NUMBER` simulates one again with full recording.")


def _sensitivities(results: CampaignResults, found: Sequence[Evaluation]) -> Iterator[Block]:
    correlations = correlation_table(found)
    if correlations[1]:
        yield Paragraph(
            "Spearman's rank correlation of metrics with inputs: 1 where a metric rises with an input, -1 where it"
            " falls, whatever the shape. Only those whose bounds exclude zero are listed, five of each metric at most."
        )
        yield _table(correlations)
    if results.content.get("sampling") == "saltelli":
        yield from _sobol(results, found)


def _sobol(results: CampaignResults, found: Sequence[Evaluation]) -> Iterator[Block]:
    """Yield the Sobol indices of each metric, or why there are none."""
    names = [str(one["name"]) for one in results.content["inputs"]]
    yield Heading(3, "Sobol indices")
    for one in found:
        for metric in one.metrics:
            try:
                indices = sobol(names, one.sample.metrics[metric.name])
            except InputError as error:  # a lost run takes the meaning of the indices, not the rest of the page
                yield Paragraph(f"{metric.name}: {error}")
                continue
            yield _table(sobol_table(metric.name, indices))


def _flown(results: CampaignResults) -> Iterator[Block]:
    content = results.content
    rows = [
        [str(one["name"]), str(one.get("kind", "")), ", ".join(map(str, _listed(one.get("targets")))),
         str(one.get("distribution", "")), str(one.get("unit") or "")]
        for one in content["inputs"]
    ]  # fmt: skip
    if rows:
        yield Heading(3, "Inputs")
        yield Table(["input", "kind", "target", "distribution", "unit"], rows, code=frozenset({2}))
    rows = [[str(one["name"]), str(one.get("text", "")), str(one.get("shown_unit") or one.get("unit") or "")]
            for one in content["metrics"]]  # fmt: skip
    yield Heading(3, "Metrics")
    yield Table(["metric", "definition", "unit"], rows, code=frozenset())
    files: Mapping[str, Any] = content.get("files") or {}
    if files:
        yield Heading(3, "Files")
        yield Table(
            ["file", "SHA-256"],
            [[str(name), ", ".join(map(str, _listed(text)))] for name, text in files.items()],
            code=frozenset({0, 1}),
        )


def _listed(value: Any) -> list[Any]:
    """Return a list as it is, anything else as a list of one."""
    return list(value) if isinstance(value, list | tuple) else [] if value is None else [value]
