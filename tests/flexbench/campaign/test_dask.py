"""A campaign on a Dask cluster: scheduler and workers as processes on the loopback interface."""

import os
import subprocess
import sys
import threading
import time
from contextlib import ExitStack

import pytest

from flexbench.campaign.campaign import read_entries, run_campaign
from flexbench.cli.parser import main
from flexbench.engine.pools import ClusterLost, DaskPool

INPUTS = """
[input.seed]
parameter = "a.seed"
distribution = "case"

[set]
"a.u" = 1.0
"a.sleep_at" = -1
"a.sleep" = 0.005
"""


class Cluster:
    """A scheduler and its workers."""

    def __init__(self, folder):
        self.folder, self.stack = folder, ExitStack()
        folder.mkdir()
        self.file = folder / "scheduler.json"
        self.scheduler = self.start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
                                    "--scheduler-file", self.file)  # fmt: skip
        self.workers = [self.worker(number) for number in range(2)]
        self.address = self.wait()

    def start(self, name, *words, **environment):
        command = [sys.executable, "-W", "ignore", "-m", f"distributed.cli.{name}", *map(str, words)]
        with (self.folder / f"{name}.log").open("ab") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, cwd=self.folder,
                                       env={**os.environ, **environment})  # fmt: skip
        self.stack.callback(process.wait)
        self.stack.callback(process.kill)
        return process

    def worker(self, number):
        """Start a worker with a folder for files of its own."""
        (self.folder / f"tmp{number}").mkdir(exist_ok=True)
        return self.start("dask_worker", "--scheduler-file", self.file, "--nthreads", 1, "--no-nanny",
                          "--no-dashboard", "--host", "127.0.0.1", "--local-directory", self.folder,
                          TMPDIR=str(self.folder / f"tmp{number}"))  # fmt: skip

    def wait(self):
        """Return the address once both workers are there."""
        import distributed

        deadline = time.monotonic() + 120.0
        while not self.file.exists():
            assert time.monotonic() < deadline
            time.sleep(0.05)
        with distributed.Client(scheduler_file=str(self.file), set_as_default=False) as client:
            client.wait_for_workers(2, timeout=120.0)
            return client.scheduler.address


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Return a cluster of two workers; a test kills one of them, and the last one the scheduler."""
    cluster = Cluster(tmp_path_factory.mktemp("dask") / "cluster")
    with cluster.stack:
        yield cluster


@pytest.mark.filterwarnings("ignore")
def test_a_cluster_gives_the_same_bytes_and_so_it_does_resumed(campaign_file, fly, cluster, tmp_path):
    path = campaign_file("cases = 8", INPUTS)
    fly(path, tmp_path / "local", 1)

    words = ["campaign", str(path), "--out", str(tmp_path / "dask"), "--scheduler", cluster.address]
    assert main(words) == 0
    assert {entry["worker"].partition(":")[0] for entry in read_entries(tmp_path / "dask").values()} == {"tcp"}
    for number in range(2):  # the files have reached each worker
        stored = list((cluster.folder / f"tmp{number}").glob("flexsat-files-*/*"))
        assert sorted(one.suffix for one in stored) == [".fmu", ".pickle"]

    def lose(process):
        deadline = time.monotonic() + 120.0
        while len(read_entries(tmp_path / "lost")) < 2 and time.monotonic() < deadline:
            time.sleep(0.01)
        process.kill()

    def on_cluster(settings):
        return DaskPool(cluster.address, settings)

    first = threading.Thread(target=lose, args=[cluster.workers[0]])
    first.start()
    run_campaign(path, tmp_path / "lost", on_cluster, lambda _: None)  # a worker vanishes: the other goes on
    first.join()

    whole = (tmp_path / "local/results.parquet").read_bytes()
    assert (tmp_path / "dask/results.parquet").read_bytes() == whole
    assert (tmp_path / "lost/results.parquet").read_bytes() == whole


@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_that_ends_is_named_and_the_campaign_goes_on_without_it(campaign_file, fly, cluster, tmp_path):
    path = campaign_file("cases = 8", INPUTS)

    def lose():
        deadline = time.monotonic() + 120.0
        while len(read_entries(tmp_path / "out")) < 2 and time.monotonic() < deadline:
            time.sleep(0.01)
        cluster.scheduler.kill()

    thread = threading.Thread(target=lose)
    thread.start()
    with pytest.raises(ClusterLost, match="the scheduler does not answer any more; start it and repeat the command"):
        run_campaign(path, tmp_path / "out", lambda settings: DaskPool(cluster.address, settings), lambda _: None)
    thread.join()
    kept = read_entries(tmp_path / "out")
    fly(path, tmp_path / "out", 1)
    fly(path, tmp_path / "whole", 1)

    assert 2 <= len(kept) < 8
    assert (tmp_path / "out/results.parquet").read_bytes() == (tmp_path / "whole/results.parquet").read_bytes()
