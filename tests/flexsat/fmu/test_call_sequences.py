"""Sequences of legal and illegal calls on the six FMUs, against the state machine of the standard."""

import json
import subprocess
import sys

from fmus.toys.builds import TOYS

PARTS = ("plant", "sensors", "controller")
SEQUENCES = 84  # of each of the six; tests/bench/fuzz_fmus.py makes 20,000


def test_five_hundred_sequences_of_calls_are_answered_as_the_standard_says(delivered):
    """In a process of its own, so that a crash is a failure: refused calls return fmi2Error, legal ones fmi2OK."""
    fmus = [delivered / name / f"{part}.fmu" for name in ("centralised", "distributed") for part in PARTS]
    done = subprocess.run(
        [sys.executable, TOYS.parent / "call_sequences.py", *fmus, "--sequences", str(SEQUENCES)],
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )

    assert done.returncode == 0, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
    results = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(results) == 6
    for result in results:
        assert result["calls"] > 10 * SEQUENCES
        # each kind of call was refused somewhere, and most of them often
        assert sum(result["refused"].values()) > 2 * SEQUENCES
