"""Sequences of legal and illegal calls on FMUs, each FMU in a process of its own: no crash, no wrong status.

    python tests/bench/fuzz_fmus.py [FOLDER_OF_FMUS] [--sequences 20000] [--seed 0]

The folder is what `flexsat build --out` fills; without one it is built. What is checked stands in
tests/fmus/call_sequences.py; a sequence that fails is printed with its number, and `--first` there repeats it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCRIPT = Path(__file__).parents[1] / "fmus" / "call_sequences.py"


def main() -> int:
    """Print a line for each FMU; return 1 if any fails."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--sequences", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as built:
        if given.folder is None:
            program = Path(sys.executable).with_name("flexsat")
            subprocess.run([program, "build", "--out", built], check=True, stdout=subprocess.DEVNULL)
        folder = given.folder or Path(built)
        fmus = sorted([*folder.glob("*/*.fmu"), *folder.glob("*/native/*.fmu")])
        if not fmus:
            parser.error(f"{folder}: no */*.fmu there; give the folder that flexsat build fills")
        failed = [path for path in fmus if not passes(path, given.sequences, given.seed)]
    return 1 if failed else 0


def passes(path: Path, sequences: int, seed: int) -> bool:
    """Run the sequences on one FMU and print what came of it."""
    begun = time.monotonic()
    command = [sys.executable, SCRIPT, path, "--sequences", str(sequences), "--seed", str(seed)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    name, took = "/".join(path.with_suffix("").parts[-3:]), time.monotonic() - begun
    if done.returncode:
        print(f"{name:24s} exit code {done.returncode} after {took:.0f} s\n{done.stdout}{done.stderr}", flush=True)
        return False
    result = json.loads(done.stdout)
    refused = sum(result["refused"].values())
    print(
        f"{name:24s} {sequences:7,d} sequences {result['calls']:9,d} calls {refused:9,d} refused {took:6.0f} s",
        flush=True,
    )
    return True


if __name__ == "__main__":
    sys.exit(main())
