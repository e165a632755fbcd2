"""Kill a campaign again and again at random moments, client and worker processes in turn, and compare its results.

.venv/bin/python tests/bench/killed_campaign.py CAMPAIGN.toml --kills 10
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import psutil

from flexbench.campaign.campaign import read_entries, run_campaign
from flexbench.engine.pools import LocalPool

FLEXSAT = [sys.executable, "-c", "from flexbench.cli.parser import program; program()", "campaign"]


def start(path, out):
    """Start a campaign with two processes."""
    command = [*FLEXSAT, str(path), "--out", str(out), "--jobs", "2"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=None)


def main():
    """Kill, go on, compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("campaign", type=Path)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    moments = random.Random(given.seed)
    with tempfile.TemporaryDirectory() as name:
        whole, killed = Path(name, "whole"), Path(name, "killed")
        total = len(run_campaign(given.campaign, whole, lambda settings: LocalPool(settings, 1)).results.numbers)
        process, kills = start(given.campaign, killed), 0
        while kills < given.kills:
            left = total - len(read_entries(killed))
            if process.poll() is not None and left == 0:
                print(f"complete after {kills} kills: give a longer campaign")
                break
            if not Path(killed, "campaign.json").exists():
                time.sleep(0.05)
                continue
            wanted = min(total, total - left + moments.randint(1, max(2, total // (given.kills + 5))))
            while len(read_entries(killed)) < wanted and process.poll() is None:
                time.sleep(0.01)
            time.sleep(moments.uniform(0.0, 0.7))
            victims = [psutil.Process(process.pid)] if process.poll() is None else []
            if kills % 2 and victims:
                with suppress(psutil.Error):
                    victims = victims[0].children() or victims
            for one in victims[:1]:
                with suppress(psutil.Error):
                    one.kill()
                    kills += 1
                    print(f"kill {kills}: {'client' if one.pid == process.pid else 'worker'}, "
                          f"{len(read_entries(killed))} of {total} runs done", flush=True)  # fmt: skip
            if victims and victims[0].pid == process.pid:
                process.wait()
                process = start(given.campaign, killed)
        code = process.wait()
        same = (whole / "results.parquet").read_bytes() == (killed / "results.parquet").read_bytes()
        print(f"exit code {code}; {'same' if same else 'OTHER'} bytes as undisturbed, with one process")


if __name__ == "__main__":
    main()
