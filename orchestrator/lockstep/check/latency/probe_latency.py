"""Measure the delay of an FMU from each input to each output, in its steps, and compare it with its dependencies."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from lockstep.array_names import array_of
from lockstep.check.dynamic.experiment import Experiment, Port, read_experiment, read_other_experiment
from lockstep.check.dynamic.probe_runner import ProbeRunner
from lockstep.check.latency.blocking_flags import Flags, blocking_flags, silent
from lockstep.check.latency.measure import PROGRESS, RESULT, measure
from lockstep.errors import InputError, RunError, compact, suggestion
from lockstep.fmi.model_description import Description, read_description
from lockstep.fmi.safe_zip import TemporaryFolderError
from lockstep.fmi.slave import Scalar
from lockstep.fmi.temporary_folder import temporary_folder
from lockstep.plan.overrides import resolve_overrides
from lockstep.system.component import Component, Kind, Value
from lockstep.system.system import System

Agreement = Literal["agrees", "contradicted", "not confirmed", "not excited", "no claim"]
NUMBERS = ("Real", "Integer", "Boolean")
SMALLER = 0.01  # of a change, where a claimed answer comes late: a filter may reject a jump, and take it a step later
SHORTEST = 1e-9  # s: times of a run are whole nanoseconds or fractions that are longer
_SHORT, _TRIAL = 12, 2.0  # steps and wall time [s] of a measurement with other values of flags


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbeSettings:
    """How to measure."""

    step: float | None = None  # [s]; None: what the FMU recommends
    steps: int = 104  # watched after a change
    starts: Mapping[str, str] | None = None  # values of parameters and inputs by name
    amplitude: float | None = None  # of every Real input, in its unit
    amplitudes: Mapping[str, float] | None = None  # by input, or by array
    kind: Kind | None = None  # None: from a shorter step, and sampled where none is possible
    seconds: float = 60.0  # wall time after which no further input is tried


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """One output and one input, or one array of inputs that were changed together.

    `least` and `most` are the steps after which the output answers, over changes before several steps; None if it did
    not. An answer is seen after the step that sees the change first: 0 steps. `claimed` is None where the model
    description does not say. Verdicts:

    - agrees: claimed and seen, or neither
    - contradicted: seen, but not claimed; or claimed, and no element of the two arrays answers before a later step, to
      smaller changes either
    - not confirmed: claimed, but this element answers later, or vanishes with the step
    - not excited: claimed, but nothing was seen
    - no claim: the model description does not say
    """

    output: str
    input: str
    least: int | None
    most: int | None
    direct: bool  # seen without any step
    feedthrough: bool  # seen within the step, and not vanishing with it
    clear: bool  # the answer is far above rounding
    claimed: bool | None
    agreement: Agreement


@dataclass(frozen=True, slots=True, kw_only=True)
class LatencyReport:
    """The measured delays of one FMU."""

    file: str
    sha256: str
    model: str
    step: float  # [s]
    step_source: str
    any_step: bool
    kind: Kind | None
    window: int  # steps watched after a change
    amounts: Mapping[str, float]  # by input that was changed
    inputs: tuple[str, ...]
    texts: tuple[str, ...]  # of these: Strings, which are not changed
    outputs: tuple[str, ...]
    pairs: tuple[Pair, ...]  # those that answer, and those that claim to; the others neither claim to nor do
    unmoved: tuple[str, ...]  # inputs that nothing answered to
    refused: tuple[str, ...]  # lines
    untried: int  # inputs, for lack of time
    unrepeatable: tuple[str, ...]  # outputs that differ between two equal runs, which are left out
    together: bool  # whether arrays were changed as a whole, for lack of time
    blocked_by: Mapping[str, float]  # flags with values that let more inputs have an answer
    smaller: tuple[str, ...] = ()  # inputs whose claimed feedthrough was seen with changes of SMALLER alone

    def of(self, agreement: Agreement) -> tuple[Pair, ...]:
        """Return the pairs of a agreement."""
        return tuple(pair for pair in self.pairs if pair.agreement == agreement)


def probe_latency(
    path: Path, settings: ProbeSettings, report: Callable[[Path], None] = lambda _: None
) -> LatencyReport:
    """Step an FMU in a process of its own, and measure its delays.

    Parameters
    ----------
    path : a co-simulation FMU of FMI 1.0, 2.0 or 3.0
    settings : how
    report : called once with the file that shows the progress

    Raises
    ------
    InputError
        If the file is no such FMU, or a setting does not fit it.
    RunError
        If the FMU fails. Nothing is left on disk in either case.
    """
    if not path.is_file():
        what = "is no file" if path.exists() else "no such file"
        raise InputError(f"{path}: {what}; give the path of an .fmu file")
    description = read_description(Component(name=path.stem.replace(".", "_") or "fmu", source=path, period=1))
    with temporary_folder("latency") as folder:
        limit = settings.seconds + 60.0
        runner = ProbeRunner(archive=path.resolve(), work=folder, time_limit=limit)
        try:
            folder_of_fmu = runner.unpack()
            experiment = (
                read_experiment(folder_of_fmu)
                if description.version == "2.0"
                else read_other_experiment(folder_of_fmu, description)
            )
        except TemporaryFolderError:
            raise
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
        experiment = _set_up(path, experiment, description, settings)
        report(runner.results / PROGRESS)
        options: dict[str, Any] = {"steps": settings.steps, "seconds": settings.seconds, "archive": str(path.resolve())}
        result = runner.run(measure, experiment, **options)
        if result.status == "error":
            raise RunError(f"{path}: {result.message}")
        found = json.loads((runner.results / RESULT).read_text(encoding="utf-8"))
        measured = _report(path, experiment, description, settings, found)
        if late := [pair for pair in measured.of("contradicted") if pair.claimed]:
            reals = (replace(port, nudge=SMALLER * port.nudge) if port.kind == "Real" else port
                     for port in experiment.inputs)  # fmt: skip
            options["steps"] = min(settings.steps, _SHORT)
            if runner.run(measure, replace(experiment, inputs=tuple(reals)), **options).status != "error":
                again = json.loads((runner.results / RESULT).read_text(encoding="utf-8"))
                found["answers"], smaller = _confirmed(found["answers"], again["answers"], late)
                measured = replace(_report(path, experiment, description, settings, found), smaller=smaller)
        if not silent(experiment.inputs, measured.unmoved):
            return measured

        def answers(flags: Flags) -> int:
            """Return how many pairs answer with other values of flags, by a short measurement."""
            chosen = {port.name: port for port in experiment.inputs if port.name in flags}
            starts = tuple((port.scalar, port.reference, _flag(port, flags[name])) for name, port in chosen.items())
            inputs = tuple(replace(port, start=flags.get(port.name, port.start)) for port in experiment.inputs)
            trial = replace(experiment, inputs=inputs, starts=(*experiment.starts, *starts))
            short: dict[str, Any] = {
                "steps": min(settings.steps, _SHORT),
                "seconds": _TRIAL,
                "archive": str(path.resolve()),
            }
            if runner.run(measure, trial, **short).status == "error":
                return 0
            return len(json.loads((runner.results / RESULT).read_text(encoding="utf-8"))["answers"])

        before = answers({})
        found_flags = blocking_flags(experiment, list(settings.starts or {}), answers, before)
    return replace(measured, blocked_by=found_flags)


def _set_up(path: Path, experiment: Experiment, description: Description, settings: ProbeSettings) -> Experiment:
    """Return the experiment with the settings, each checked against the FMU."""
    if not any(port.kind in NUMBERS for port in experiment.inputs):
        raise InputError(f"{path}: has no numeric inputs, so that nothing can be changed")
    if not experiment.outputs:
        raise InputError(f"{path}: has no outputs, so that nothing can answer")
    if settings.steps < 1:
        raise InputError(f"--steps {settings.steps}: must be 1 or more")
    if not 0.0 < settings.seconds < math.inf:
        raise InputError(f"--time-limit {settings.seconds:g}: must be > 0 s")
    if settings.step is not None:
        if not SHORTEST <= settings.step < math.inf:
            raise InputError(f"--step-size {settings.step:g}: must be {SHORTEST:g} s or more, and finite")
        experiment = replace(experiment, step=settings.step, step_source="as given")
    starts = _starts(path, description, settings.starts or {})
    inputs = _amplified(tuple(_started(port, starts) for port in experiment.inputs), settings)
    chosen = tuple((kind, reference, value) for kind, reference, value in starts.values())
    return replace(experiment, inputs=inputs, starts=chosen)


def _starts(path: Path, description: Description, values: Mapping[str, Value]) -> dict[str, tuple[Scalar, int, Any]]:
    """Return type, value reference and value by name."""
    system = System(name="probe", tick=1, components=(Component(name="fmu", source=path, period=1),))
    found: dict[str, tuple[Scalar, int, Any]] = {}
    for key, value in values.items():
        for _, variable, parsed in resolve_overrides(f"fmu.{key}", value, system, {"fmu": description}):
            if variable.scalar is not None:  # others cannot be set, which resolve_overrides refuses
                found[variable.name] = (variable.scalar, variable.reference, parsed)
    return found


def _started(port: Port, starts: Mapping[str, tuple[Scalar, int, Any]]) -> Port:
    if port.name not in starts or port.kind == "String":
        return port
    return replace(port, start=float(starts[port.name][2]))


def _amplified(ports: tuple[Port, ...], settings: ProbeSettings) -> tuple[Port, ...]:
    amplitudes = dict(settings.amplitudes or {})
    reals = [port.name for port in ports if port.kind == "Real"]
    for name, amount in amplitudes.items():
        if not any(name in (port, array_of(port)) for port in reals):
            raise InputError(
                f"--amplitude {name}: no such Real input; there are {compact(reals)}{suggestion(name, reals)}"
            )
        _check_amplitude(f"--amplitude {name}", amount)
    if settings.amplitude is not None:
        _check_amplitude("--amplitude", settings.amplitude)
    amplified = []
    for port in ports:
        amplitude = amplitudes.get(port.name, amplitudes.get(array_of(port.name), settings.amplitude))
        if amplitude is not None and port.kind == "Real":
            if port.minimum + 2.0 * amplitude > port.maximum:
                span = f"{port.minimum:g} to {port.maximum:g}"
                raise InputError(
                    f"--amplitude {amplitude:g}: {port.name} ranges from {span}; give at most half of that"
                )
            low, high = port.minimum + amplitude * 2.0, port.maximum - amplitude * 2.0
            port = replace(port, nudge=amplitude, start=min(max(port.start, low), high) if low <= high else port.start)
        amplified.append(port)
    return tuple(amplified)


def _check_amplitude(what: str, amount: float) -> None:
    if not 0.0 < amount < math.inf:
        raise InputError(f"{what}: {amount:g} must be a number > 0")


def _report(
    path: Path, experiment: Experiment, description: Description, settings: ProbeSettings, found: Mapping[str, Any]
) -> LatencyReport:
    kind = settings.kind or (None if experiment.any_step else "sampled")
    pairs = _pairs(experiment, settings, found)
    tried = [_named(inputs) for inputs in found["tried"]]
    moved = {pair.input for pair in pairs if pair.least is not None}
    return LatencyReport(
        file=str(path),
        sha256=description.sha256,
        model=description.model,
        step=experiment.step,
        step_source=experiment.step_source,
        any_step=experiment.any_step,
        kind=kind,
        window=found["window"],
        amounts=found["amounts"],
        inputs=tuple(port.name for port in experiment.inputs),
        texts=tuple(port.name for port in experiment.inputs if port.kind == "String"),
        outputs=tuple(port.name for port in experiment.outputs),
        pairs=pairs,
        unmoved=tuple(name for name in tried if name not in moved),
        refused=tuple(found["refused"]),
        untried=found["untried"],
        unrepeatable=tuple(found["unrepeatable"]),
        together=found["together"],
        blocked_by={},
    )


def _confirmed(
    answers: Sequence[Mapping[str, Any]], again: Sequence[Mapping[str, Any]], late: Sequence[Pair]
) -> tuple[list[dict[str, Any]], tuple[str, ...]]:
    """Return the answers with those that come at once to smaller changes, and the inputs of these."""
    wanted = {(pair.output, pair.input) for pair in late}
    at_once = {(one["output"], _named(one["inputs"])) for one in again if one["feedthrough"]} & wanted
    merged = [
        {**one, "least": 0, "feedthrough": True} if (one["output"], _named(one["inputs"])) in at_once else dict(one)
        for one in answers
    ]
    return merged, tuple(dict.fromkeys(name for _, name in sorted(at_once)))


def _flag(port: Port, value: float) -> bool | int:
    return bool(value) if port.kind == "Boolean" else int(value)


def _named(inputs: list[str]) -> str:
    return inputs[0] if len(inputs) == 1 else inputs[0].partition("[")[0]


def _pairs(experiment: Experiment, settings: ProbeSettings, found: Mapping[str, Any]) -> tuple[Pair, ...]:
    """Return the pairs that answer, or claim to."""
    seen = {(answer["output"], _named(answer["inputs"])): answer for answer in found["answers"]}
    no_answer = {"least": None, "most": None, "direct": False, "feedthrough": False, "clear": False}
    pairs = []
    for port in experiment.outputs:
        if port.name in found["unrepeatable"]:
            continue
        for inputs in found["tried"]:
            claimed = None if port.feeds is None else not set(port.feeds).isdisjoint(inputs)
            answer = seen.get((port.name, _named(inputs)), no_answer)
            if answer is no_answer and not claimed:
                continue
            feedthrough = answer["feedthrough"]
            if settings.kind == "continuous" and not experiment.any_step:  # after such a step it answers anyhow
                feedthrough = answer["direct"]
            elif settings.kind == "sampled":
                feedthrough = answer["direct"] or answer["least"] == 0
            pairs.append(
                Pair(
                    output=port.name,
                    input=_named(inputs),
                    least=answer["least"],
                    most=answer["most"],
                    direct=answer["direct"],
                    feedthrough=feedthrough,
                    clear=answer["clear"],
                    claimed=claimed,
                    agreement="agrees",
                )
            )
    earliest: dict[tuple[str, str], int] = {}  # of two arrays: a maker may claim for all elements alike
    for pair in pairs:
        if pair.least is not None:
            earliest[_arrays(pair)] = min(pair.least, earliest.get(_arrays(pair), pair.least))
    clear = {_arrays(pair) for pair in pairs if pair.clear}
    late = {arrays for arrays, least in earliest.items() if least > 0 and arrays in clear}
    return tuple(replace(pair, agreement=_agreement(pair, _arrays(pair) in late)) for pair in pairs)


def _agreement(pair: Pair, late: bool) -> Agreement:
    if pair.claimed is None:
        return "no claim"
    if not pair.claimed:
        return "contradicted" if pair.feedthrough else "agrees"
    if pair.feedthrough:
        return "agrees"
    if pair.least is None:
        return "not excited"
    return "contradicted" if late else "not confirmed"


def _arrays(pair: Pair) -> tuple[str, str]:
    return array_of(pair.output), array_of(pair.input)
