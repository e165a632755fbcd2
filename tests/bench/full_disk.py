"""Call every command that writes where the disk is full: `python tests/bench/full_disk.py FMUS` (root only).

FMUS is a folder that `flexsat build` has filled. Each command writes to a disk of its own, with too little room for
what it writes, or none. It has to end with 1 or 2 and one line that names the cause; what was on the disk before is
unchanged, and nothing half-written is left. It prints a table, and ends with 1 if anything is wrong.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

FLEXSAT = Path(sys.executable).with_name("flexsat")
LOCKSTEP = (sys.executable, "-m", "lockstep")
SIGNS = (".partial", ".part", ".tmp")  # at the end of names of files that are half-written
MAY_BE_EMPTY = {"events.jsonl", "signals.arrows"}  # of a run that could not record a second
MOUNTED = 1000  # [kB] of a disk without a file that fills it
CAUSES = ("No space left on device", "cannot be written", "cannot be made")


def commands(fmus: Path, run: Path, disk: Path) -> dict[str, tuple[int, list[object]]]:
    """Return the room on the disk [kB] and the command line of each case; `copy` on the disk is a run."""
    system, opened = fmus / "centralised/fine_pointing.ssd", fmus / "centralised/fine_pointing_open_loop.ssd"
    controller, copy, out = fmus / "centralised/controller.fmu", disk / "copy", disk / "out"
    short = ("--stop-time", 60)
    cases: dict[str, tuple[int, list[object]]] = {
        "run": (200, [FLEXSAT, "run", system, *short, "--out", out]),
        "run, full": (0, [FLEXSAT, "run", system, *short, "--out", out]),
        "run over a run": (0, [FLEXSAT, "run", system, *short, "--out", copy, "--overwrite"]),
        "run, mount point": (MOUNTED, [FLEXSAT, "run", system, *short, "--out", disk]),
        "run with checkpoints": (900, [FLEXSAT, "run", system, *short, "--checkpoint-every", 1, "--out", out]),
        "resume": (0, [FLEXSAT, "run", "--resume", copy]),
        "lockstep run": (200, [*LOCKSTEP, "run", system, *short, "--out", out]),
        "branch": (200, [FLEXSAT, "branch", run / "checkpoints/t=2.ckpt", "--vary", "plant.wheel.friction_torque[3]",
                         0, 0.01, "--stop-time", 60, "--out", out]),
        "margins": (0, [FLEXSAT, "margins", system, "--analytic-only", "--out", out]),
        "health": (300, [FLEXSAT, "health", system, "--seeds", 1, "--stop-time", 60, "--out", out]),
        "robustness": (300, [FLEXSAT, "robustness", "--configuration", "centralised", "--levels", 1, "--fmus", fmus,
                             "--stop-time", 20, "--out", out]),
        "waterfall": (300, [FLEXSAT, "waterfall", opened, "--points", 2, "--stop-time", 20, "--out", out]),
        "budget --split": (300, [FLEXSAT, "budget", "--split", system, "--stop-time", 20, "--out", out]),
        "equivalence": (100, [FLEXSAT, "equivalence", "--configuration", "centralised", "--scenario", "fine_pointing",
                              "--stop-time", 20, "--fmus", fmus, "--out", out]),
        "budget": (0, [FLEXSAT, "budget", copy, "--window", 1, "--separation", 1, "--observation", 1, "--from", 1]),
        "spectra": (0, [FLEXSAT, "spectra", copy, "--from", 1]),
        "figures": (20, [FLEXSAT, "figures", "--configuration", "centralised", "--out", out]),
        "report": (100, [FLEXSAT, "report", copy]),
        "write-ssp": (20, [FLEXSAT, "write-ssp", system, "--out", disk / "out.ssp"]),
        "adapt": (0, [FLEXSAT, "adapt", controller, "--like", "controller:centralised", "--out", disk / "out.toml"]),
        "timeline": (0, [FLEXSAT, "timeline", system, "--svg", disk / "out.svg"]),
        "probe-latency": (0, [FLEXSAT, "probe-latency", controller, "--json", disk / "out.json"]),
        "build": (500, [FLEXSAT, "build", "--configuration", "centralised", "--out", out]),
    }  # fmt: skip
    for kind in ("csv", "mat", "hdf5", "parquet"):
        cases[f"export {kind}"] = (100, [FLEXSAT, "export", copy, "--format", kind])
    for kind in ("html", "json", "junit"):
        cases[f"check --{kind}"] = (0, [FLEXSAT, "check", "--static", controller, f"--{kind}", disk / "out.txt"])
    return cases


@contextmanager
def mounted(folder: Path, size: int) -> Iterator[Path]:
    """Mount a disk in memory, of so many kB, inside the block."""
    folder.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}k", "none", folder], check=True)
    try:
        yield folder
    finally:
        subprocess.run(["umount", folder], check=True)


def leave_room(disk: Path, room: int) -> None:
    """Fill a disk until only so many kB are free."""
    block = bytes(4096)
    with (disk / "filler").open("wb", buffering=0) as filler, suppress(OSError):
        while True:
            filler.write(block)
    with (disk / "filler").open("r+b") as filler:
        filler.truncate((disk / "filler").stat().st_size - 1024 * room)


def contents(folder: Path) -> dict[str, bytes]:
    """Return the content of each file."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def call(command: list[object], disk: Path, scratch: Path) -> tuple[str, list[str]]:
    """Call a command; return a summary, and what is wrong."""
    before = contents(disk / "copy") if (disk / "copy").exists() else {}
    environment = os.environ | {"TMPDIR": str(scratch), "COLUMNS": "120"}
    done = subprocess.run(
        list(map(str, command)), capture_output=True, text=True, check=False, env=environment, cwd=scratch
    )
    lines = [line for line in done.stderr.splitlines() if line.startswith(("flexsat: ", "lockstep: "))]
    wrong = []
    if done.returncode not in (1, 2):
        wrong.append(f"exit code {done.returncode}: {done.stderr[-300:]}")
    if len(lines) != 1 or not any(cause in lines[0] for cause in CAUSES) or "Traceback" in done.stderr:
        wrong.append(f"said {done.stderr[-600:]!r}")
    if before:
        after = contents(disk / "copy")
        wrong += [f"changed {name}" for name in before if before[name] != after.get(name)]
    for path in disk.rglob("*"):
        hidden = path.name.startswith(".") or path.name.endswith(SIGNS)
        if hidden or (path.is_file() and path.stat().st_size == 0 and path.name not in MAY_BE_EMPTY):
            wrong.append(f"left {path.relative_to(disk)}")
    for record in disk.rglob("run.toml"):
        status = tomllib.loads(record.read_text())["status"]
        if "copy" not in record.parts and status not in ("failed", "completed", "interrupted"):
            wrong.append(f"{record.relative_to(disk)} says {status}")
    wrong += [f"left {path.name} in the temporary folder" for path in scratch.iterdir()]
    return f"{done.returncode}  {lines[0][:150] if lines else ''}", wrong


def main() -> int:
    """Call all commands and print a table."""
    if len(sys.argv) < 2:
        print(__doc__)
        return 2
    fmus, only = Path(sys.argv[1]).absolute(), set(sys.argv[2:])
    failed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run, scratch = folder / "run", folder / "scratch"
        scratch.mkdir()
        system = fmus / "centralised/fine_pointing.ssd"
        subprocess.run([FLEXSAT, "run", system, "--stop-time", "5", "--checkpoint", "2", "--out", run], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
        for title, (room, command) in commands(fmus, run, folder / "disk").items():
            if only and title not in only:
                continue
            with mounted(folder / "disk", 40_000 if room < MOUNTED else MOUNTED) as disk:
                if disk / "copy" in command:
                    shutil.copytree(run, disk / "copy")
                if title == "resume":
                    record = (disk / "copy/run.toml").read_text().replace('"completed"', '"running"')
                    (disk / "copy/run.toml").write_text(record)
                if room < MOUNTED:
                    leave_room(disk, room)
                summary, wrong = call(command, disk, scratch)
            print(f"{title:22} {summary.replace(str(folder), '')}", flush=True)
            for text in wrong:
                print(f"    WRONG {text}", flush=True)
            failed += bool(wrong)
    print("all right" if not failed else f"{failed} wrong")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
