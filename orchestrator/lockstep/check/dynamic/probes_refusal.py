"""Probes of what an FMU refuses, and what it logs: bad steps, bad references, log messages."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from ctypes import byref, c_bool, c_char, c_char_p, c_double, c_int, c_uint

from lockstep.check.dynamic.checked_instance import CheckedInstance
from lockstep.check.dynamic.probe_process import ProbeResult, ProbeTask
from lockstep.errors import RunError
from lockstep.fmi.slave import FATAL, OK, WARNING
from lockstep.fmi.slave import status_name as name_of_status

BAD_REFERENCE = 4_000_000_007  # no model has so many variables
FRACTION = 1.5  # of the fixed step
_DOUBLE = {"1.0": "Real", "2.0": "Real", "3.0": "Float64"}
_KINDS = {
    version: ((_DOUBLE[version], c_double), (integer, c_int), ("Boolean", boolean), ("String", c_char_p))
    for version, integer, boolean in (
        ("1.0", "Integer", c_char),
        ("2.0", "Integer", c_int),
        ("3.0", "Int32", c_bool),
    )
}


def _name(task: ProbeTask, status: int) -> str:
    return name_of_status(task.experiment.prefix, status)


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
    # FMI asks for steps > 0; hosts make errors, and an FMU that accepts them silently hides them. A step of NaN is no
    # such error: no comparison finds it, and well-kept FMUs integrate towards it without end
    odd = {"zero": 0.0, "negative": -h}
    others = {f"{factor * h:g} s": factor * h for factor in (FRACTION, 0.5)} if fixed else {}
    details, accepted = [], []
    for words, step in (others | odd).items():
        instance = _after_a_step(task)
        status = instance.try_step(task.experiment.time(1), step)
        details.append(f"step {words}: {_name(task, status)}")
        accepted += [words] * (status in (OK, WARNING))
        _close_quietly(instance)
        if status >= FATAL:
            text = f"a step of {words} is answered with {_name(task, status)}, which ends every instance in the process"
            return ProbeResult(status="warning", message=text, details=tuple(details))
    wrong = [words for words in accepted if words in others]
    if wrong:
        message = f"its step is fixed at {h:g} s, but it silently accepts a step of {' and of '.join(wrong)}"
        return ProbeResult(status="error", message=message, details=tuple(details))
    if accepted:
        message = f"silently accepts a step that is {' or '.join(accepted)}"
        return ProbeResult(status="warning", message=message, details=tuple(details))
    made = "only its own step is accepted" if fixed else f"makes steps of {0.5 * h:g}, {h:g} and {2 * h:g} s"
    return ProbeResult(message=f"{made}; zero and negative ones are refused", details=tuple(details))


def invalid_reference(task: ProbeTask) -> ProbeResult:
    """Read and write a value reference that no variable has."""
    details, unnoticed = [], []
    prefix, counted = task.experiment.prefix, (1,) * (task.experiment.fmi == "3.0")  # values are counted there too
    for kind, ctype in _KINDS[task.experiment.fmi]:
        for verb in ("Get", "Set"):
            instance = _after_a_step(task)
            name = f"{verb}{kind}"
            reference, value = c_uint(BAD_REFERENCE), (ctype * 1)()
            if verb == "Set" and kind == "String":
                value[0] = b""
            instance.messages.clear()
            status = instance.call(name, byref(reference), 1, value, *counted)
            logged = [text for level, _, _, text in instance.messages if level != OK]
            details.append(f"{prefix}{name}: {_name(task, status)}{', logged' if logged else ''}")
            if status in (OK, WARNING) and not logged:
                unnoticed.append(f"{prefix}{name}")
            _close_quietly(instance)
            if status >= FATAL:
                text = f"{prefix}{name} answers a bad reference with {_name(task, status)}"
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
    prefix, oldest = task.experiment.prefix, task.experiment.fmi == "1.0"
    names = (c_char_p * max(1, len(categories)))(*(name.encode() for name in categories))
    status = OK if oldest else instance.call("SetDebugLogging", 1, len(categories), names)  # 1.0 has no categories
    if status not in (OK, WARNING):
        listed = ", ".join(categories) or "none"
        words = f"{prefix}SetDebugLogging refuses the declared categories ({listed})"
        return ProbeResult(status="warning", message=words)
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
        return ProbeResult(
            status="warning", message=f"{words} is answered with {_name(task, status)}, but nothing is logged"
        )
    level, category, name, text = logged[0]
    details = (
        f"{words}: {_name(task, status)}, logged {_name(task, level)}, category {category or '(empty)'}: {text}",
    )
    if category not in categories and not oldest:
        listed = ", ".join(categories) or "none"
        return ProbeResult(status="warning", message=f"logs in the category {category!r}; declared are {listed}",
                       details=details)  # fmt: skip
    if name != instance.name and task.experiment.fmi != "3.0":  # which passes no name
        return ProbeResult(status="warning", message=f"its message names the instance {name!r} instead of "
                       f"{instance.name!r}", details=details)  # fmt: skip
    kept = "the category" if oldest else "the declared category"
    return ProbeResult(message=f"{words}: a message in {kept} {category}", details=details)


def _induce(task: ProbeTask, instance: CheckedInstance) -> tuple[str, int] | None:
    """Do what is wrong until it is noticed; return what was done, and the status."""
    h, at = task.experiment.step, task.experiment.time(1)
    reference, value = c_uint(BAD_REFERENCE), (c_double * 1)()
    counted = (1,) * (task.experiment.fmi == "3.0")
    attempts: list[tuple[str, Callable[[], int]]] = [
        ("a negative step", lambda: instance.try_step(at, -h)),
        (
            "a bad value reference",
            lambda: instance.call(f"Get{_DOUBLE[task.experiment.fmi]}", byref(reference), 1, value, *counted),
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
