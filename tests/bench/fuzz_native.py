"""Fuzz the toy and the native components by libFuzzer, with AddressSanitizer and UndefinedBehaviorSanitizer.

    python tests/bench/fuzz_native.py [COMPONENT ...] [--runs 100000] [--seed 1]

The components are toy, plant, turning_plant (of a spacecraft whose arrays turn), sensors and controller, of few modes,
and environment, thrusters and mission; all of them without a name. What is checked stands in tests/fmus/native/fuzz/:
`sequences` makes calls, `states` changes bytes of serialised states. It needs clang with libFuzzer.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from fmus.native.fuzz_targets import STEPS, build_targets, fuzzer_is_missing, run_target, sources_of


def main() -> int:
    """Print a line for each component and target; return 1 if any fails."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("component", nargs="*", help=f"of {', '.join(STEPS)}")
    parser.add_argument("--runs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    unknown = set(given.component) - set(STEPS)
    if unknown or fuzzer_is_missing():
        parser.error(fuzzer_is_missing() or f"{', '.join(unknown)}: there are {', '.join(STEPS)}")
    failed = 0
    with tempfile.TemporaryDirectory(prefix="flexsat_fuzz_") as folder:
        for component in given.component or STEPS:
            targets = build_targets(component, sources_of(component), Path(folder, component))
            for target, program in targets.items():
                failed += not passes(f"{component} {target}", program, given.runs, given.seed)
    return 1 if failed else 0


def passes(name: str, program: Path, runs: int, seed: int) -> bool:
    """Run a target, and print what came of it."""
    begun = time.monotonic()
    try:
        calls = run_target(program, runs, seed)
    except AssertionError as error:
        print(f"{name:22s} failed after {time.monotonic() - begun:.0f} s\n{error}", flush=True)
        return False
    counts = ", ".join(f"{number:,d} {what}" for what, number in calls.items())
    print(f"{name:22s} {runs:,d} inputs in {time.monotonic() - begun:.0f} s: calls {counts}", flush=True)
    return True


if __name__ == "__main__":
    sys.exit(main())
