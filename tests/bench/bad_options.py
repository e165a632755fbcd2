"""Give every option of every command bad values: `python tests/bench/bad_options.py FMUS [COMMAND ...]`.

FMUS is a folder that `flexsat build` has filled. Each call has to end with exit code 2, nothing on standard output, and
one line that names the option; or the value is one that the option accepts, and the command runs. The calls that ran
are listed for a reader to judge, those with another answer as findings; exit code 1 if there are any. Paths of files
are not judged, but for empty ones. A call is a copy of this process with 2 s of processor time.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import resource
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import click

from flexbench.cli.parser import PROGRAM as FLEXSAT
from lockstep.__main__ import PROGRAM as LOCKSTEP
from lockstep.cli.parameter_types import NamedPath, Several

PROGRAMS = {"flexsat": FLEXSAT, "lockstep": LOCKSTEP}
EXAMPLES = Path(__file__).parents[2] / "examples"
SECONDS = 2
BAD = ("nan", "inf", "-1", "0", "1e400", "", "text", "1e-30")
LONG = 2000  # values where a few are meant
CAMPAIGN = """
[campaign]
cases = 2
stop_time = 0.1
[systems]
one = "{fmus}/centralised/fine_pointing.ssd"
[metric.pointing]
of = "pointing_error"
take = "rms"
unit = "arcsec"
"""

# how a value stands in the text of an option: beside the value alone, within these
WITHIN = {
    "--set": ("plant.wheel.torque_limit={}", "plant.seed={}", "plant.{}=1", "{}.seed=1", "{}=1"),
    "--delay": ("sensors:controller={}", "{}:controller=1", "sensors:{}=1"),
    "--step-size": ("controller={}", "{}=0.005"),
    "--tolerance": ("plant={}", "{}=1e-6"),
    "--replace": ("controller={}", "{}=controller.fmu"),
    "--shadow": ("controller={}", "{}=controller.fmu"),
    "--source": ("star_tracker.mrp={}", "{}=sensors.star_tracker.mrp"),
    "--dispersion": ("frequency={}", "{}=1"),
    "--like": ("controller:{}", "{}:centralised"),
    "--stop-when": ("p95(pointing) within {} %", "p{}(pointing) within 5 %", "p95({}) within 5 %"),
    "--scheduler": ("tcp://{}:1", "tcp://127.0.0.1:{}"),
}


def bases(fmus: Path, results: Path, files: Path) -> dict[str, list[str]]:
    """Return a command line of each command that is good, and short where it runs."""
    system, opened = (
        str(fmus / "centralised/native" / f"{name}.ssd") for name in ("fine_pointing", "fine_pointing_open_loop")
    )
    controller, run = str(fmus / "centralised/native/controller.fmu"), str(results)
    short = ["--stop-time", "0.1"]
    return {
        "flexsat build": [],
        "flexsat new": ["my.toml"],
        "flexsat spacecraft": ["centralised"],
        "flexsat modal": [str(files / "tables")],
        "flexsat run": [system, *short],
        "flexsat paper": [],
        "flexsat branch": [str(results / "checkpoints/t=0.1.ckpt"), "--vary", "plant.wheel.friction_torque[3]", "0"],
        "flexsat campaign": [str(files / "campaign.toml"), "--out", "campaign"],
        "flexsat report": [run],
        "flexsat figures": [run],
        "flexsat export": [run, "--format", "csv"],
        "flexsat export-c": ["controller", "--fmus", str(fmus)],
        "flexsat margins": [system],
        "flexsat budget": [run],
        "flexsat spectra": [run],
        "flexsat health": [system, "--stop-time", "45"],
        "flexsat robustness": ["--fmus", str(fmus)],
        "flexsat compare-layouts": ["--fmus", str(fmus)],
        "flexsat waterfall": [opened],
        "flexsat shadow": [str(files / "shadow")],
        "flexsat equivalence": ["--fmus", str(fmus)],
        "flexsat check": [controller],
        "flexsat adapt": [controller, "--like", "controller:centralised"],
        "flexsat check-adapter": [controller, "--adapter", str(files / "adapter.toml")],
        "flexsat probe-latency": [controller],
        "flexsat write-ssp": [system, "--out", "out.ssp"],
        "flexsat bundle": [str(fmus / "centralised/native/fine_pointing.ssd"), "--out", "out.fmu"],
        "flexsat timeline": [system],
        "lockstep show": [system],
    }


def values(option: click.Option) -> Iterator[list[str]]:
    """Yield the bad values of an option, each as words of the command line."""
    name = max(option.opts, key=len)
    if isinstance(option.type, NamedPath):
        yield [name, ""]
        return
    for bad in BAD:
        if option.nargs > 1:
            yield [name, *[bad] * option.nargs]
            yield [name, "1", *[bad] * (option.nargs - 1)]
        else:
            yield [name, bad]
        for text in WITHIN.get(name, ()) if bad in ("nan", "-1", "", "text") else ():
            yield [name, text.format(bad)]
    if option.nargs > 1:
        yield [name, "2", "1"]
    if isinstance(option.type, Several):
        yield [name, *["1"] * LONG]
        yield [name, *map(str, range(1, LONG))]
        yield [name, "1", "1"]
    elif option.multiple:
        yield [name, "1"] * LONG


def answer(label: str, words: list[str], limit: int = SECONDS) -> tuple[int, str, str]:
    """Give a command in a copy of this process; return its exit code, or minus a signal, and what it printed."""
    with tempfile.TemporaryDirectory() as folder:
        out, err = Path(folder, ".out"), Path(folder, ".err")
        process = os.fork()
        if process == 0:
            code = 99
            try:
                os.setsid()
                os.chdir(folder)
                resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
                for stream, path in ((1, out), (2, err)):
                    os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND), stream)
                code = PROGRAMS[label].run(words)
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code)
        status = os.waitpid(process, 0)[1]
        with suppress(ProcessLookupError):
            os.killpg(process, signal.SIGKILL)  # its own processes
        return os.waitstatus_to_exitcode(status), *(
            path.read_text(encoding="utf-8", errors="replace") if path.exists() else "" for path in (out, err)
        )


def judge(option: str, given: str, code: int, out: str, err: str) -> str:
    """Return what is wrong with an answer: empty if nothing is, `ran` if the value was accepted."""
    lines = err.strip().splitlines()
    if "Traceback" in err or code in (70, 99):
        return "a bug"
    if code in (0, -signal.SIGXCPU, -signal.SIGKILL) or (code == 1 and "SIGXCPU" in err):  # or its worker was
        return "ran"
    if code != 2:
        return f"exit code {code}"
    if out:
        return "printed first"
    if len(lines) != 1:
        return f"{len(lines)} lines"
    words = option.removeprefix("--").replace("-", " ")  # "record period 0.1 s: ..." names it too
    return "" if option in lines[0] or words in lines[0] or _key(given) in lines[0] else "no option named"


def _key(given: str) -> str:
    """Return the name of NAME=V, which names it, or a text that is in no message."""
    key = given.partition("=")[0]
    return f"{key}: " if key else "\0"


def prepare(fmus: Path, folder: Path) -> Path:
    """Make what the commands read: a run with a checkpoint, a shadow run, a campaign, modal tables, an adapter."""
    system, controller = fmus / "centralised/fine_pointing.ssd", fmus / "centralised/native/controller.fmu"
    run = ["run", str(system), "--native", "--stop-time", "0.3"]
    (folder / "campaign.toml").write_text(CAMPAIGN.format(fmus=fmus), encoding="utf-8")
    (folder / "tables").mkdir()
    (folder / "tables/modes.csv").write_text("frequency\n1\n", encoding="utf-8")
    for words in (
        [*run, "--checkpoint", "0.1", "--out", str(folder / "run")],
        [*run, "--shadow", f"controller={controller}", "--out", str(folder / "shadow")],
        ["adapt", str(controller), "--like", "controller:centralised", "--out", str(folder / "adapter.toml")],
    ):
        code, _, err = answer("flexsat", words, 300)
        assert code == 0, (words, code, err)
    return folder / "run"


def main() -> int:
    """Print what was accepted and the findings; return the exit code."""
    fmus, chosen = Path(sys.argv[1]).absolute(), sys.argv[2:]
    calls = findings = 0
    for package in ("flexsat", "lockstep", "flexbench"):  # once, in place of in each call
        for module in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
            if not module.name.endswith("__main__"):
                with suppress(ImportError):
                    importlib.import_module(module.name)
    with tempfile.TemporaryDirectory() as folder:
        results = prepare(fmus, Path(folder))
        for command, base in bases(fmus, results, Path(folder)).items():
            label, name = command.split()
            if chosen and name not in chosen and command not in chosen:
                continue
            found = PROGRAMS[label].get_command(click.Context(PROGRAMS[label]), name)
            assert found is not None
            for option in found.params:
                if not isinstance(option, click.Option) or option.is_flag:
                    continue
                for words in values(option):
                    code, out, err = answer(label, [name, *base, *words])
                    wrong = judge(words[0], words[1], code, out, err)
                    calls += 1
                    findings += wrong not in ("", "ran")
                    if wrong:
                        line = (err.strip().splitlines() or [""])[-1]
                        print(
                            f"{wrong:26} {command} {' '.join(map(repr, words))[:90]}: {code} {line[:300]}", flush=True
                        )
    print(f"{calls} calls, {findings} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
