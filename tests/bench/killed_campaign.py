"""Kill a campaign again and again at random moments, its parts in turn, and compare its results.

.venv/bin/python tests/bench/killed_campaign.py CAMPAIGN.toml --kills 10           # client, worker processes
.venv/bin/python tests/bench/killed_campaign.py CAMPAIGN.toml --kills 10 --dask    # client, Dask worker, scheduler

With --rounds the whole is repeated. Each client that was not killed must end with 0, or with 1 where its scheduler was.
"""

import argparse
import random
import signal
import socket
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
LOOK = 0.05  # s


class Local:
    """Processes of the client."""

    parts = ("client", "worker")
    words = ("--jobs", "2")

    def victim(self, part, client):
        """Return the process to kill."""
        own = psutil.Process(client.pid)
        return own if part == "client" else next(iter(own.children()), None)

    def mend(self):
        """Start what was killed: nothing, as the client does that."""

    def end(self):
        """End what was started."""


class Cluster:
    """A scheduler and two workers on the loopback interface."""

    parts = ("client", "worker", "scheduler")

    def __init__(self, folder):
        self.folder = folder
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.words = ("--scheduler", f"tcp://127.0.0.1:{self.port}")
        self.scheduler, self.workers = None, [None, None]
        self.mend()

    def start(self, name, *words):
        command = [sys.executable, "-W", "ignore", "-m", f"distributed.cli.{name}", *map(str, words)]
        with (self.folder / f"{name}.log").open("ab") as log:
            return subprocess.Popen([*command, "--no-dashboard", "--host", "127.0.0.1"], stdout=log, stderr=log)

    def mend(self):
        """Start what was killed; workers of a scheduler that is gone anew."""
        for killed in (self.scheduler, *self.workers):
            with suppress(AttributeError, subprocess.TimeoutExpired):
                killed.wait(0.5)
        if self.scheduler is None or self.scheduler.poll() is not None:
            self.end()
            self.scheduler = self.start("dask_scheduler", "--port", self.port)
        for k, worker in enumerate(self.workers):
            if worker is None or worker.poll() is not None:
                self.workers[k] = self.start("dask_worker", self.words[1], "--nthreads", 1, "--no-nanny",
                                             "--local-directory", self.folder)  # fmt: skip
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            with suppress(OSError), socket.create_connection(("127.0.0.1", self.port), 1.0):
                return
            time.sleep(LOOK)

    def victim(self, part, client):
        """Return the process to kill."""
        process = {"client": client, "worker": self.workers[0], "scheduler": self.scheduler}[part]
        return psutil.Process(process.pid)

    def end(self):
        """End what was started."""
        for process in (*self.workers, self.scheduler):
            if process is not None:
                process.kill()
                process.wait()


def start(path, out, words):
    """Start the client."""
    return subprocess.Popen([*FLEXSAT, str(path), "--out", str(out), *words], stdout=subprocess.DEVNULL, stderr=None)


def kill_and_compare(path, folder, engine, kills, moments):
    """Kill the parts of a campaign in turn, go on each time, and return whether all is as it is undisturbed."""
    whole, killed = folder / "whole", folder / "killed"
    if not (whole / "results.parquet").exists():
        run_campaign(path, whole, lambda settings: LocalPool(settings, 1))
    total = len(read_entries(whole))
    client, count, right = start(path, killed, engine.words), 0, True

    def ended():
        """Note with what the client ended, if it did."""
        nonlocal right
        code = client.poll()
        fine = code in (None, 0)
        right &= fine
        if not fine:
            print(f"CLIENT ENDED WITH {code}", flush=True)
        return code is not None

    while count < kills and not ended():
        done = len(read_entries(killed)) if Path(killed, "campaign.json").exists() else -1
        wanted = min(total, done + moments.randint(1, max(2, total // (kills + 5))))
        while len(read_entries(killed)) < wanted and client.poll() is None:
            time.sleep(LOOK)
        time.sleep(moments.uniform(0.0, 0.7))
        part = engine.parts[count % len(engine.parts)]
        with suppress(psutil.Error):
            victim = None if ended() else engine.victim(part, client)
            if victim is not None:
                victim.kill()
                count += 1
                print(f"kill {count}: {part}, {len(read_entries(killed))} of {total} runs done", flush=True)
                if part != "worker":  # a worker is started anew, by the client or below
                    code = client.wait()
                    right &= code == (-signal.SIGKILL if part == "client" else 1)
                    print(f"client ended with {code}", flush=True)
                engine.mend()
                if part != "worker":
                    client = start(path, killed, engine.words)
    if count < kills:
        print(f"complete after {count} kills: give a longer campaign")
    code = client.wait()
    same = (whole / "results.parquet").read_bytes() == (killed / "results.parquet").read_bytes()
    print(f"exit code {code}; {'same' if same else 'OTHER'} bytes as undisturbed, with one process", flush=True)
    return right and same and code == 0


def main():
    """Kill, go on, compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("campaign", type=Path)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--dask", action="store_true")
    given = parser.parse_args()
    moments = random.Random(given.seed)
    with tempfile.TemporaryDirectory() as name:
        engine = Cluster(Path(name)) if given.dask else Local()
        try:
            right = 0
            for _ in range(given.rounds):
                right += kill_and_compare(given.campaign, Path(name), engine, given.kills, moments)
                for left in Path(name, "killed").rglob("*.jsonl"):
                    left.unlink()
                Path(name, "killed").rename(Path(name, f"killed-{random.random()}"))
        finally:
            engine.end()
    print(f"{right} of {given.rounds} rounds right")
    return 0 if right == given.rounds else 1


if __name__ == "__main__":
    sys.exit(main())
