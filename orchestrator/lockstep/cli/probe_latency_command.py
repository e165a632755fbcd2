"""The command `probe-latency`: its options, its progress, and what it prints."""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event, Thread

from lockstep.check.latency.probe_latency import ProbeSettings, probe_latency
from lockstep.cli.probe_latency_text import as_json, as_lines
from lockstep.cli.run_options import assignments
from lockstep.errors import InputError

TEXT = "measure an FMU's delay from each input to each output, and whether its dependencies tell its feedthrough"
EXAMPLE = """exit code: 0 no claim is contradicted; 1 one is, or the FMU failed; 2 bad input; 130 Ctrl-C
example:
  {} vendor.fmu --set gain=2 --set q_ok=3 --amplitude 0.01 --json latency.json
"""


def add_latency_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `probe-latency`."""
    parser.add_argument(
        "fmu", type=Path, help="a co-simulation FMU of any maker and version of FMI; runs in a process of its own"
    )
    parser.add_argument("--step", metavar="S", help="its step in seconds (default: what it recommends, or 0.001)")
    parser.add_argument("--steps", type=int, default=104, metavar="N",
                        help="steps to watch after a change (default: 104)")  # fmt: skip
    parser.add_argument("--set", action="append", default=[], metavar="NAME=V",
                        help="value of a parameter, or start value of an input; an array takes V,V,...")  # fmt: skip
    parser.add_argument("--amplitude", action="append", default=[], metavar="A",
                        help="change of every Real input in its unit, or INPUT=A (default: 0.01 of its range, or "
                             "0.001 of its start or nominal value)")  # fmt: skip
    parser.add_argument("--kind", choices=("sampled", "continuous"),
                        help="what it is: outputs hold from a step's start, or are true at its end (default: told by "
                             "a shorter step; sampled where it makes none)")  # fmt: skip
    parser.add_argument("--time-limit", type=float, default=60.0, metavar="S",
                        help="wall time for all changes; arrays are changed as a whole where it is too short "
                             "(default: 60)")  # fmt: skip
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write every pair as JSON; - prints it instead")


def probe_as_told(options: argparse.Namespace) -> int:
    """Measure, print the matrix, write the file asked for; return the exit code."""
    settings = _settings(options)
    printed = options.json is not None and str(options.json) == "-"
    if options.json is not None and not printed:
        _refuse(options.json, options.fmu)
    try:
        with _progress(str(options.fmu)) as watch:
            report = probe_latency(options.fmu, settings, watch)
    except KeyboardInterrupt:
        print(f"{options.fmu}: interrupted; nothing was written", file=sys.stderr)
        return 130
    if printed:
        print(as_json(report), end="")
    else:
        print("\n".join(as_lines(report, shutil.get_terminal_size((120, 40)).columns)))
        if options.json is not None:
            options.json.write_text(as_json(report), encoding="utf-8")
            print(options.json)
    return 1 if report.of("contradicted") else 0


def _settings(options: argparse.Namespace) -> ProbeSettings:
    general, single = None, {}
    for text in options.amplitude:
        name, _, amount = text.rpartition("=")
        value = _number(amount, f"--amplitude {text}")
        if name:
            single[name] = value
        else:
            general = value
    return ProbeSettings(
        step=None if options.step is None else _number(options.step, f"--step {options.step}"),
        steps=options.steps,
        starts=_values(options.set),
        amplitude=general,
        amplitudes=single,
        kind=options.kind,
        seconds=options.time_limit,
    )


def _values(texts: list[str]) -> dict[str, str]:
    for text in texts:
        name, equals, _ = text.partition("=")
        if not (name and equals):
            raise InputError(f"--set {text}: write NAME=VALUE")
    return assignments(texts)


def _number(text: str, what: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{what}: {text!r} is no number") from None


def _refuse(output: Path, fmu: Path) -> None:
    """Find out now whether the file can be written."""
    if output.is_dir():
        raise InputError(f"--json {output}: is a folder; give the name of a file")
    if output.resolve() == fmu.resolve():
        raise InputError(f"--json {output}: is the FMU; give another name")
    if not output.absolute().parent.is_dir():
        raise InputError(f"--json {output}: there is no folder {output.parent}; make it, or give another name")


@contextmanager
def _progress(title: str) -> Iterator[Watch]:
    watch = Watch(title)
    try:
        yield watch
    finally:
        watch.close()


class Watch:
    """Print what the process of the FMU tells of its progress: over one line of a terminal, in lines elsewhere."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._terminal = sys.stderr.isatty()
        self._end = Event()
        self._thread: Thread | None = None

    def __call__(self, file: Path) -> None:
        """Begin to look at a file."""
        self._thread = Thread(target=self._look, args=(file,), daemon=True)
        self._thread.start()

    def _look(self, file: Path) -> None:
        told = ""
        while not self._end.wait(0.2 if self._terminal else 5.0):
            with suppress(OSError, UnicodeDecodeError):
                text = file.read_text(encoding="utf-8")
                if text != told:
                    told = text
                    line = f"{self._title}: {text}"
                    print(f"\r\x1b[K{line}" if self._terminal else line, end="" if self._terminal else "\n",
                          file=sys.stderr, flush=True)  # fmt: skip

    def close(self) -> None:
        """Stop, and leave a clean line."""
        self._end.set()
        if self._thread is not None:
            self._thread.join()
            if self._terminal:
                print("\r\x1b[K", end="", file=sys.stderr, flush=True)
