"""Probes of what an FMU refuses, and what it logs: bad steps, bad references, log messages."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from ctypes import byref, c_char_p, c_double, c_int, c_uint

from lockstep.check.dynamic.checked_instance import CheckedInstance
from lockstep.check.dynamic.probe_process import ProbeResult, ProbeTask
from lockstep.errors import RunError
from lockstep.fmi.slave import FATAL, OK, WARNING
from lockstep.fmi.slave import status_name as name_of_status

BAD_REFERENCE = 4_000_000_007  # no model has so many variables
FRACTION = 1.5  # of the fixed step


def _name(status: int) -> str:
    return name_of_status("fmi2", status)


def refuses_step(task: ProbeTask) -> ProbeResult:
    """Try steps that the FMU cannot make, each with a new instance, and others that it declares it can."""
    h, fixed = task.experiment.step, not task.experiment.any_step
    if not fixed:
        for factor in (0.5, 2.0):
            instance = _after_a_step(task)
            try:
                instance.step(task.experiment.time(1), factor * h)
            except RunError as error:
                raise RunError(f"claims variable steps, but refuses one of {factor * h:g} s: {error}") from None
            instance.close()
    # FMI 2.0 asks for steps > 0; hosts make errors, and an FMU that accepts them silently hides them
    odd = {"zero": 0.0, "negative": -h, "not-a-number": math.nan}
    others = {f"{factor * h:g} s": factor * h for factor in (FRACTION, 0.5)} if fixed else {}
    details, accepted = [], []
    for words, step in (others | odd).items():
        instance = _after_a_step(task)
        status = instance.try_step(task.experiment.time(1), step)
        details.append(f"step {words}: {_name(status)}")
        accepted += [words] * (status in (OK, WARNING))
        _close_quietly(instance)
        if status >= FATAL:
            text = f"a step of {words} is answered with {_name(status)}, which ends every instance in the process"
            return ProbeResult(status="warning", message=text, details=tuple(details))
    wrong = [words for words in accepted if words in others]
    if wrong:
        message = f"its step is fixed at {h:g} s, but it silently accepts a step of {' and of '.join(wrong)}"
        return ProbeResult(status="error", message=message, details=tuple(details))
    if accepted:
        message = f"silently accepts a step that is {' or '.join(accepted)}"
        return ProbeResult(status="warning", message=message, details=tuple(details))
    made = "only its own step is accepted" if fixed else f"makes steps of {0.5 * h:g}, {h:g} and {2 * h:g} s"
    return ProbeResult(message=f"{made}; zero, negative and not-a-number are refused", details=tuple(details))


def invalid_reference(task: ProbeTask) -> ProbeResult:
    """Read and write a value reference that no variable has."""
    details, unnoticed = [], []
    for kind, ctype in (("Real", c_double), ("Integer", c_int), ("Boolean", c_int), ("String", c_char_p)):
        for verb in ("Get", "Set"):
            instance = _after_a_step(task)
            name = f"{verb}{kind}"
            reference, value = c_uint(BAD_REFERENCE), (ctype * 1)()
            if verb == "Set" and kind == "String":
                value[0] = b""
            instance.messages.clear()
            status = instance.call(name, byref(reference), 1, value)
            logged = [text for level, _, _, text in instance.messages if level != OK]
            details.append(f"fmi2{name}: {_name(status)}{', logged' if logged else ''}")
            if status in (OK, WARNING) and not logged:
                unnoticed.append(f"fmi2{name}")
            _close_quietly(instance)
            if status >= FATAL:
                text = f"fmi2{name} answers a bad reference with {_name(status)}"
                text += ", which ends every instance in the process"
                return ProbeResult(status="warning", message=text, details=tuple(details))
    if unnoticed:
        message = f"accepted without a message by {', '.join(unnoticed)}"
        return ProbeResult(status="info", message=message, details=tuple(details))
    return ProbeResult(message="each is refused or logged", details=tuple(details))


def logging(task: ProbeTask) -> ProbeResult:
    """Switch the log categories on, cause an error, and examine the message."""
    categories = task.experiment.categories
    instance = task.open("named by the host")
    names = (c_char_p * max(1, len(categories)))(*(name.encode() for name in categories))
    status = instance.call("SetDebugLogging", 1, len(categories), names)
    if status not in (OK, WARNING):
        listed = ", ".join(categories) or "none"
        return ProbeResult(status="warning", message=f"fmi2SetDebugLogging refuses the declared categories ({listed})")
    instance.initialise()
    instance.put([table[0] for table in instance.stimuli()])
    instance.step(task.experiment.time(0), task.experiment.step)
    instance.messages.clear()
    induced = _induce(task, instance)
    if induced is None:
        return ProbeResult(status="skipped", message="no error could be induced: it accepts bad steps and references")
    words, status = induced
    logged = [message for message in instance.messages if message[0] != OK]
    if not logged:
        return ProbeResult(status="warning", message=f"{words} is answered with {_name(status)}, but nothing is logged")
    level, category, name, text = logged[0]
    details = (f"{words}: {_name(status)}, logged {_name(level)}, category {category or '(empty)'}: {text}",)
    if category not in categories:
        listed = ", ".join(categories) or "none"
        return ProbeResult(status="warning", message=f"logs in the category {category!r}; declared are {listed}",
                       details=details)  # fmt: skip
    if name != instance.name:
        return ProbeResult(status="warning", message=f"its message names the instance {name!r} instead of "
                       f"{instance.name!r}", details=details)  # fmt: skip
    return ProbeResult(message=f"{words}: a message in the declared category {category}", details=details)


def _induce(task: ProbeTask, instance: CheckedInstance) -> tuple[str, int] | None:
    """Do what is wrong until it is noticed; return what was done, and the status."""
    h, at = task.experiment.step, task.experiment.time(1)
    reference, value = c_uint(BAD_REFERENCE), (c_double * 1)()
    attempts: list[tuple[str, Callable[[], int]]] = [
        ("a negative step", lambda: instance.try_step(at, -h)),
        (
            "a bad value reference",
            lambda: instance.call("GetReal", byref(reference), 1, value),
        ),
    ]
    if not task.experiment.any_step:
        attempts.insert(0, ("a step that it cannot make", lambda: instance.try_step(at, FRACTION * h)))
    for words, attempt in attempts:
        status = attempt()
        if status not in (OK, WARNING) or any(level != OK for level, *_ in instance.messages):
            return words, status
    return None


def _after_a_step(task: ProbeTask) -> CheckedInstance:
    instance = task.started()
    instance.put([table[0] for table in instance.stimuli()])
    instance.step(task.experiment.time(0), task.experiment.step)
    return instance


def _close_quietly(instance: CheckedInstance) -> None:
    """Close an instance after a wrong call; whether that works is not judged here."""
    with suppress(RunError):
        instance.close()
