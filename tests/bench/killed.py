"""Kill runs at twenty moments, start pairs at twenty offsets: `python tests/bench/killed.py [MOMENTS [ROW...]]`.

A run is killed with SIGKILL: with and without checkpoints, its FMUs isolated or in the process of the master, into a
new folder and over an earlier run. Then: what is on disk is readable and equal to the rows of a run that was not
killed; no process is left; the run goes on, from its newest checkpoint or anew, to the same bytes; nothing is left in
the temporary folder and beside the results. Two runs of different lengths start one after the other, into one folder,
over an earlier run, and into the default folder: each command succeeds with its own rows, or is refused in one line.

It prints a table, and ends with 1 if anything was lost, mixed or left behind.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
import psutil

sys.path.insert(0, str(Path(__file__).parents[1]))

from fmus.wanderer.wanderer import wanderer
from lockstep import Component, Connection, Signals, System, load_system, read_signals, simulate, write_ssd
from lockstep.checkpoint.file import newest_checkpoint
from lockstep.checkpoint.schedule import CheckpointSchedule

MS = 1_000_000
STOP = 2.0  # [s] simulated
STOPS = ("1.5", "2")  # of two runs at once
PACE = 2.0  # times real time, so that the moments are spread over the steps too
START = {"offset": 0.25, "number": 0, "flag": False}
COMMAND = [sys.executable, "-m", "lockstep", "run"]


class Bench:
    """Two FMUs in a loop, the rows of their whole run, and a folder to work in."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.temporary = folder / "temporary"
        self.temporary.mkdir()
        fmu = wanderer(folder, "good")
        parts = tuple(
            Component(name=n, source=fmu, period=MS, kind="sampled", isolated=False, parameters=START)
            for n in ("a", "b")
        )
        wires = tuple(
            Connection(from_component=one, output="y", to_component=other, input="u", delay=1)
            for one, other in ("ab", "ba")
        )
        shared = System(name="pair", tick=MS, stop_time=int(STOP * 1e9), components=parts, connections=wires)
        isolated = replace(shared, components=tuple(replace(part, isolated=True) for part in parts))
        for name, system in (("shared", shared), ("isolated", isolated)):
            (folder / name).mkdir()
            write_ssd(system, folder / name / "pair.ssd")
        isolated_run = load_system(folder / "isolated/pair.ssd")
        simulate(isolated_run, folder / "saved", stop_time=0.1, checkpoints=CheckpointSchedule(times=["0.05"]))
        self.checkpoint = folder / "saved/checkpoints/t=0.05.ckpt"
        simulate(shared, folder / "whole")
        self.whole = read_signals(folder / "whole")
        self.bytes = (folder / "whole/signals.parquet").read_bytes()

    def start(self, system: str, out: Path | None, *options: object, cwd: Path | None = None) -> subprocess.Popen[str]:
        """Start a run in a process of its own."""
        where = [] if out is None else ["--out", out]
        command = [*COMMAND, self.folder / system / "pair.ssd", *where, *options]
        return subprocess.Popen(
            list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=cwd,
            env=os.environ | {"TMPDIR": str(self.temporary), "PYTHONWARNINGS": "error"},
        )  # fmt: skip

    def left_processes(self) -> list[psutil.Process]:
        """Return the processes that a killed run has left, after they had time to end."""
        deadline = time.monotonic() + 60.0  # a worker that is still starting ends once it has started
        while left := [process for process in psutil.process_iter() if self._belongs(process)]:
            if time.monotonic() > deadline:
                return left
            time.sleep(0.02)
        return []

    def _belongs(self, process: psutil.Process) -> bool:
        try:
            mine = process.environ().get("TMPDIR", "").startswith(str(self.temporary))
            return mine and process.status() != psutil.STATUS_ZOMBIE
        except psutil.Error:
            return False

    def is_part(self, signals: Signals) -> bool:
        """Return whether these are the first rows of the whole run."""
        rows = len(signals.time)
        return all(np.array_equal(signals[name], self.whole[name][:rows]) for name in self.whole.columns)


def wait_until(process: subprocess.Popen[str], moment: float, out: Path) -> None:
    """Wait so many seconds; a negative number is of simulated time, from the first row on."""
    if moment >= 0.0:
        time.sleep(moment)
        return
    stream = out / "signals.arrows"
    while process.poll() is None and not stream.exists():
        time.sleep(0.005)
    time.sleep(-moment / PACE)


def killed(bench: Bench, moment: float, system: str, checkpoints: bool, over: bool) -> Iterator[tuple[str, bool]]:
    """Kill a run at a moment, see `wait_until`; yield what was found, and whether it is right."""
    home = Path(tempfile.mkdtemp(dir=bench.folder))
    out = home / "out"
    if over:
        done = bench.start("shared", out, "--stop-time", "0.5")
        yield "earlier run", done.wait() == 0
        done.communicate()
    options: list[object] = ["--pace", PACE, *(["--overwrite"] if over else [])]
    options += ["--checkpoint-every", "0.3"] if checkpoints else []
    with bench.start(system, out, *options) as process:
        wait_until(process, moment, out)
        process.kill()
        process.communicate()
    yield "no process is left", not bench.left_processes()
    status = "none"
    if (out / "run.toml").exists():
        record = tomllib.loads((out / "run.toml").read_text())
        status = record["status"] if record["stop_time"] == STOP else "earlier"
    yield f"was {status}", status in {"none", "earlier", "running", "completed"} and not (over and status == "none")
    if status == "earlier":
        yield "the earlier run is whole", len(read_signals(out).time) == 501 and bench.is_part(read_signals(out))
    if status == "running" and (out / "signals.arrows").exists() and (out / "signals.arrows").stat().st_size > 5000:
        yield "rows are readable", bench.is_part(read_signals(out))
    newest = newest_checkpoint(out) if status == "running" else None
    if status == "completed":
        yield "the bytes of a completed run", (out / "signals.parquet").read_bytes() == bench.bytes
    if newest is not None:
        command = [*COMMAND, "--resume", str(out)]
        environment = os.environ | {"TMPDIR": str(bench.temporary)}
        again = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
        yield "resumed", again.returncode == 0
    else:
        with bench.start(system, out, "--overwrite") as process:
            process.communicate()
        yield "run again", process.returncode == 0
    yield "the same bytes", (out / "signals.parquet").read_bytes() == bench.bytes
    kept = {"events.jsonl", "run.toml", "signals.parquet", *(["checkpoints"] if newest else [])}
    yield "nothing else is in the folder", {path.name for path in out.iterdir()} == kept
    yield "nothing is beside the folder", [path.name for path in home.iterdir()] == ["out"]
    yield "temporary folders are removed", not list(bench.temporary.iterdir())


def killed_study(bench: Bench, moment: float) -> Iterator[tuple[str, bool]]:
    """Kill `flexsat branch`, which runs two jobs in two processes, each with FMUs of their own."""
    out = Path(tempfile.mkdtemp(dir=bench.folder))
    command = [Path(sys.executable).with_name("flexsat"), "branch", bench.checkpoint, "--vary", "a.gain", "1", "2"]
    with subprocess.Popen(
        [*map(str, command), "--stop-time", "1000", "--out", str(out)], stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL, env=os.environ | {"TMPDIR": str(bench.temporary)},
    ) as process:  # fmt: skip
        time.sleep(moment)
        process.kill()
    left = [" ".join(process.cmdline()[1:4]) for process in bench.left_processes()]
    yield f"no process is left {left}", not left
    statuses = [tomllib.loads(path.read_text())["status"] for path in out.glob("*/run.toml")]
    yield f"was {' and '.join(statuses) or 'none'}", set(statuses) <= {"running"}
    for folder in out.iterdir():
        if (folder / "signals.arrows").exists() and (folder / "signals.arrows").stat().st_size > 5000:
            signals = read_signals(folder)
            steps = signals["a.steps"]
            yield "rows are readable", np.array_equal(steps, steps[:1] + np.arange(len(steps)))
    with bench.start("shared", out / "after") as process:
        process.communicate()
    yield "temporary folders are removed", not list(bench.temporary.iterdir())


def paired(bench: Bench, offset: float, kind: str) -> Iterator[tuple[str, bool]]:
    """Start two runs, the second so many seconds later; yield what was found, and whether it is right."""
    home = Path(tempfile.mkdtemp(dir=bench.folder))
    out = None if kind == "default" else home / "out"
    if kind == "overwrite":
        with bench.start("shared", out, "--stop-time", "0.5") as process:
            process.communicate()
    both = []
    for number, stop in enumerate(STOPS):
        time.sleep(offset * number)
        options = ["--stop-time", stop, "--pace", PACE, *(["--overwrite"] if kind == "overwrite" else [])]
        both.append(bench.start("shared", out, *options, cwd=home))
    errors = [process.communicate()[1].splitlines() for process in both]
    codes = [process.returncode for process in both]
    found = {}
    for path in home.rglob("run.toml"):
        record, signals = tomllib.loads(path.read_text()), read_signals(path.parent)
        right = record["status"] == "completed" and len(signals.time) == round(record["stop_time"] * 1000) + 1
        yield "a folder holds one whole run", right and bench.is_part(signals)
        found[path.parent.name] = f"{record['stop_time']:g}"
        names = sorted(file.name for file in path.parent.iterdir())
        yield "nothing else is in it", names == ["events.jsonl", "run.toml", "signals.parquet"]
    won = [stop for stop, code in zip(STOPS, codes, strict=True) if code == 0]
    refused = [error for error, code in zip(errors, codes, strict=True) if code == 2]
    yield f"codes {sorted(codes)}", sorted(codes) in ([0, 0], [0, 2])
    yield "refused in one line", all(len([x for x in error if x.startswith("lockstep: ")]) == 1 for error in refused)
    match kind:
        case "default":
            yield "both are there", sorted(found.values()) == won == list(STOPS)
        case "new":
            yield "that of the command that succeeded", list(found.values()) == won
        case _:
            yield "that of a command that succeeded", next(iter(found.values())) in won
    yield "temporary folders are removed", not list(bench.temporary.iterdir())


def main() -> int:
    """Run all and print a table."""
    count, words = int(sys.argv[1]) if len(sys.argv) > 1 else 20, sys.argv[2:]
    wrong = 0
    with tempfile.TemporaryDirectory() as name:
        bench = Bench(Path(name))
        began = time.monotonic()
        with bench.start("shared", bench.folder / "timed", "--pace", PACE) as process:
            process.communicate()
        length = time.monotonic() - began  # [s] of wall time
        early, late = np.linspace(0.0, length, count - count // 2), -np.linspace(0.01, STOP, count // 2)
        moments, offsets = [*early.tolist(), *late.tolist()], np.linspace(0.0, 1.02 * length, count).tolist()
        print(f"{count} moments or offsets; a run takes {length:.1f} s")
        for title, row in rows(bench, moments, offsets).items():
            if not words or any(word in title for word in words):
                wrong += report(title, [list(result) for result in row])
    print("nothing lost, mixed or left behind" if not wrong else f"{wrong} wrong")
    return 1 if wrong else 0


def rows(bench: Bench, moments: list[float], offsets: list[float]) -> dict[str, Iterator[Iterator[tuple[str, bool]]]]:
    """Return the rows of the table, each begun when it is read."""
    found: dict[str, Iterator[Iterator[tuple[str, bool]]]] = {}
    for system, saved, over in product(("shared", "isolated"), (False, True), (False, True)):
        parts = (system, "checkpoints" if saved else "no checkpoints", "over a run" if over else "new folder")
        found[", ".join(parts)] = map(partial(killed, bench, system=system, checkpoints=saved, over=over), moments)
    found["study of two isolated runs"] = map(partial(killed_study, bench), (2.0 * offset for offset in offsets))
    for kind in ("new", "overwrite", "default"):
        found[f"two runs, {kind}"] = map(partial(paired, bench, kind=kind), offsets)
    return found


def report(title: str, results: list[list[tuple[str, bool]]]) -> int:
    """Print one row of the table, and what is wrong; return how much that is."""
    found = Counter(text for result in results for text, _ in result if text.startswith(("was ", "codes ", "resumed")))
    wrong = Counter(text for result in results for text, right in result if not right)
    right = sum(all(right for _, right in result) for result in results)
    print(
        f"  {title:42} {right:3} of {len(results)} right   ", ", ".join(f"{t}: {n}" for t, n in sorted(found.items()))
    )
    for text, times in wrong.items():
        print(f"    WRONG {times} times: {text}")
    return sum(wrong.values())


if __name__ == "__main__":
    sys.exit(main())
