"""Write the record of a run: run.toml, which suffices to repeat it, and events.jsonl, its events in order."""

import json
import os
import platform
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from itertools import takewhile
from pathlib import Path
from typing import Any

from lockstep.fmi.model_description import Description
from lockstep.plain_values import plain_value
from lockstep.standard_streams import printable
from lockstep.system.clock import Time, stored_seconds
from lockstep.system.component import Component, Value
from lockstep.system.system import System

RUN = "run.toml"
PARTIAL = f".{RUN}.partial"  # while it is written
EVENTS = "events.jsonl"
_PACKAGES = ("numpy", "fmpy", "lxml", "pyarrow")
_LEVELS = ("ok", "warning", "discard", "error", "fatal", "pending")  # by status of FMI
_ROOM = 1000  # bytes at the end of run.toml while the run goes on, for how it ends
_LONGEST_REASON = 200  # letters, where the room is scarce
_MOST_MESSAGES = 1000  # of one component in the events: a slave that logs at each step must not fill the disk

Table = dict[str, object]


@cache
def _versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that this process has loaded, which do not change in it."""
    return {"python": platform.python_version(), **{name: version(name) for name in _PACKAGES}}


def describe_run(
    system: System,
    descriptions: Mapping[str, Description],
    parameters: Mapping[str, Mapping[str, Value]],
    overrides: Mapping[str, object],
    stop_time: Time,
    record: Sequence[str],
    record_period: Time,
    faults: Sequence[Table] = (),
    tolerances: Mapping[str, float] | None = None,
    warnings: Sequence[str] = (),
    inputs: Sequence[Table] = (),
) -> Table:
    """Return the content of run.toml: everything that a run depends on. Times are in seconds."""
    delays = sorted({(c.from_component, c.to_component, c.delay) for c in system.connections})
    return {
        "status": "running",
        "simulated_time": 0.0,
        "wall_time": 0.0,
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        **({"start_time": stored_seconds(system.start_time)} if system.start_time else {}),
        "stop_time": stored_seconds(stop_time),
        "tick": stored_seconds(system.tick),
        "record": list(record),
        "record_period": stored_seconds(record_period),
        "system": {"name": system.name, "path": str(system.path or ""), "sha256": system.sha256 or ""},
        **({"warnings": list(warnings)} if warnings else {}),
        "versions": dict(_versions()),
        "overrides": {key: plain_value(value, key) for key, value in overrides.items()},
        "component": [
            {
                "name": c.name,
                "source": str(c.source),
                "sha256": descriptions[c.name].sha256,
                "model": descriptions[c.name].model,
                "guid": descriptions[c.name].guid,
                "period": stored_seconds(c.shadow.period if c.shadow else c.period),
                "offset": stored_seconds(c.offset),
                "kind": c.kind,
                "isolated": bool(c.isolated),
                **({"grouped": True} if c.grouped else {}),
                **_tolerance(c, tolerances or {}),
                "parameters": dict(parameters[c.name]),
                **_adapter(c),
                **_shadow(c, descriptions, tolerances or {}),
            }
            for c in system.components
        ],
        **({"inputs": list(inputs)} if inputs else {}),
        **({"faults": list(faults)} if faults else {}),
        "latency": [{"from": start, "to": end, "delay": delay} for start, end, delay in delays],
    }


def _adapter(component: Component) -> Table:
    if component.adapter is None or component.stands_for is None:
        return {}
    adapter, replaced = component.adapter, component.stands_for
    return {"adapter": str(adapter.path), "adapter_sha256": adapter.sha256, "stands_for": str(replaced.source)}


def _tolerance(component: Component, tolerances: Mapping[str, float]) -> Table:
    """Return the tolerance that was passed to the FMU, if there was one."""
    return {"tolerance": tolerances[component.name]} if component.name in tolerances else {}


def _shadow(component: Component, descriptions: Mapping[str, Description], tolerances: Mapping[str, float]) -> Table:
    if component.shadow is None:
        return {}
    shadow, over = component.shadow.component, component.shadow.switchover
    table: Table = {
        "name": shadow.name,
        "source": str(shadow.source),
        "sha256": descriptions[shadow.name].sha256,
        "model": descriptions[shadow.name].model,
        "guid": descriptions[shadow.name].guid,
        "period": stored_seconds(shadow.period),
        "isolated": bool(shadow.isolated),
        **({"grouped": True} if shadow.grouped else {}),
        **_tolerance(shadow, tolerances),
        "outputs": list(component.shadow.outputs),
        "compared": [o for o in component.shadow.outputs if descriptions[component.name].variables[o].scalar == "Real"],
        "blend": stored_seconds(component.shadow.blend),
        **({} if over is None else {"switchover": stored_seconds(over)}),
        **_adapter(shadow),
    }
    return {"shadow": table}


def write_run_record(folder: Path, content: Mapping[str, object], *, rename: bool = True) -> Path:
    """Replace run.toml in one step: a reader sees the old one or the new one. Return what was written.

    While the run goes on the file is longer than its text, so that `end_run_record` succeeds on a full disk.
    Without `rename` the new one stays beside it, with another name.
    """
    partial = folder / PARTIAL
    try:
        partial.write_text(to_toml(content) + _room(content), encoding="utf-8")
        return partial.replace(folder / RUN) if rename else partial
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(folder / RUN)) from None


def end_run_record(folder: Path, content: Mapping[str, object]) -> None:
    """Replace run.toml in one step; on a full disk overwrite its bytes, which takes no further space."""
    try:
        write_run_record(folder, content)
    except OSError:
        path = folder / RUN
        size = path.stat().st_size
        short = {name: value for name, value in content.items() if name != "time"}
        texts = (to_toml(fields).encode() for fields in (content, short, _short_reason(short)))
        text = next((text for text in texts if len(text) <= size), None)
        if text is not None:
            with path.open("r+b") as file:
                file.write(text.ljust(size, b"\n"))


def _short_reason(content: Mapping[str, object]) -> Mapping[str, object]:
    """Return the record with so much of the reason that there is room for it."""
    return {**content, "reason": f"{str(content.get('reason', ''))[:_LONGEST_REASON]}..."}


def _room(content: Mapping[str, object]) -> str:
    return f"{' ' * _ROOM}\n" if content.get("status") == "running" else ""


def to_toml(content: Mapping[str, object]) -> str:
    """Write scalars, then tables, then arrays of tables, as TOML 1.0; raise InputError for what it cannot keep."""
    plain = {key: plain_value(value, key) for key, value in content.items()}
    return "\n".join(_lines(plain, "")) + "\n"


def _lines(content: Mapping[str, object], prefix: str) -> list[str]:
    lines: list[str] = []
    later: list[str] = []
    for key, value in content.items():
        name = f"{prefix}{_key(key)}"
        if isinstance(value, Mapping):
            later += ["", f"[{name}]", *_lines(value, f"{name}.")]
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            for entry in value:
                later += ["", f"[[{name}]]", *_lines(entry, f"{name}.")]
        else:
            lines.append(f"{_key(key)} = {_literal(value)}")
    return lines + later


def _key(key: str) -> str:
    return key if key.replace("_", "").replace("-", "").isalnum() and key.isascii() else _text(key)


def _text(text: str) -> str:
    known = text.encode("utf-8", "replace").decode()  # TOML has no escape for half a character
    return printable(json.dumps(known, ensure_ascii=False))  # TOML's basic strings escape as JSON's


def _literal(value: object) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case int() | float():
            return repr(value)
        case list():
            return f"[{', '.join(map(_literal, value))}]"
    return _text(str(value))


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptEvents:
    """The events of a run at some time, a line each, and how many messages each component had logged."""

    lines: tuple[str, ...]
    counts: Mapping[str, int]


class Events:
    """Append events, one JSON object a line, each with its simulated time; before `open` they wait."""

    def __init__(self, time: float = 0.0) -> None:
        self.time = time  # [s] simulated; the master keeps it
        self._source: Callable[[], float] | None = None
        self._waiting: list[str] = []
        self._file: int | None = None
        self._path: Path | None = None
        self._counts: Counter[str] = Counter()

    def follow(self, source: Callable[[], float] | None) -> None:
        """Read the present simulated time from elsewhere while ticks run; None: from `time` again."""
        self._source = source

    def open(self, folder: Path, keep: int = 0) -> None:
        """Create events.jsonl, or keep so many bytes of it, and write the waiting events."""
        self._path = folder / EVENTS
        self._file = os.open(folder / EVENTS, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        os.ftruncate(self._file, keep)
        waiting, self._waiting = self._waiting, []
        for line in waiting:
            self._write(line)

    def saved(self) -> dict[str, object]:
        """Return the size of the file, and how many messages each component has logged."""
        assert self._file is not None
        return {"size": os.fstat(self._file).st_size, "counts": dict(self._counts)}

    def open_again(self, folder: Path, saved: Mapping[str, Any]) -> None:
        """Continue the events of the same run after those that it had when it was saved; write the waiting ones."""
        self._counts.update(Counter(saved["counts"]))
        self.open(folder, int(saved["size"]))

    def kept(self) -> KeptEvents:
        """Return the events so far."""
        lines = tuple(self._waiting)
        if self._path is not None:
            lines = tuple(f"{line}\n" for line in self._path.read_text(encoding="utf-8").split("\n")[:-1])
        return KeptEvents(lines=lines, counts=dict(self._counts))

    def put_back(self, kept: KeptEvents) -> None:
        """Go back to the events that the run had at some time, in this branch of it or another."""
        self._counts = Counter(kept.counts)
        if self._file is None:
            self._waiting = list(kept.lines)
            return
        equal = takewhile(lambda pair: pair[0] == pair[1], zip(self.kept().lines, kept.lines, strict=False))
        size = sum(len(line.encode()) for line, _ in equal)
        os.ftruncate(self._file, size)
        _write_whole(self._file, "".join(kept.lines).encode()[size:])

    def add(self, event: str, **details: object) -> None:
        """Write an event at the present simulated time."""
        entry = {"time": self.time if self._source is None else self._source(), "event": event, **details}
        line = json.dumps(entry, ensure_ascii=False, default=_plain)
        # an FMU's message must not control the terminal of whoever prints the file
        self._write((line if line.isprintable() else json.dumps(entry, default=_plain)) + "\n")

    def log(self, component: str, status: int, category: str, message: str) -> None:
        """Write an FMU's message if it is a warning or worse, up to a number of them."""
        if status == 0:
            return
        self._counts[component] += 1
        if self._counts[component] <= _MOST_MESSAGES:
            level = _LEVELS[status] if 0 <= status < len(_LEVELS) else "unknown"
            self.add("log", component=component, level=level, category=category, message=message)
        elif self._counts[component] == _MOST_MESSAGES + 1:
            self.add("log", component=component, level="warning", message="further messages are not listed")

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def _write(self, line: str) -> None:
        if self._file is None:
            self._waiting.append(line)
        else:
            _write_whole(self._file, line.encode("utf-8", "replace"))  # unbuffered: it survives a kill


def _plain(value: object) -> object:
    return plain_value(value, EVENTS)


def _write_whole(file: int, data: bytes) -> None:
    """Append data wholly or not at all: half a line on a full disk would spoil the next one."""
    written = 0
    try:
        while written < len(data):
            written += os.write(file, data[written:])
    except OSError:
        os.ftruncate(file, os.fstat(file).st_size - written)
        raise
