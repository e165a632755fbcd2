"""Runs of flexsat's native FMUs one after the other in one process: rows of fresh ones, and no memory or files left."""

import ctypes
import gc
import os
from dataclasses import replace

import psutil
import pyarrow
import pytest

from flexbench.campaign.campaign_file import read_campaign
from flexbench.campaign.flight import fly, unpack
from flexbench.campaign.histories import Histories
from flexbench.campaign.measure import digest_of_all
from flexbench.campaign.orders import prepare
from lockstep import read_signals
from lockstep.fmi.temporary_folder import unpacking_folder

CAMPAIGN = """
[campaign]
seed = 3
cases = 2
stop_time = 0.3
record_period = 0.01
keep_fmus = {keep}
[systems]
distributed = "{fmus}/distributed/fine_pointing.ssd"
centralised = "{fmus}/centralised/slew.ssd"
[input.seed]
parameter = ["plant.seed", "sensors.seed"]
distribution = "case"
[input.frequency]
parameter = "plant.dispersion.frequency"
distribution = "uniform"
loc = -0.05
scale = 0.1
[metric.pointing]
of = "pointing_error"
unit = "arcsec"
[metric.stability]
of = "budget"
index = "RPE"
window = 0.05
unit = "arcsec"
"""


@pytest.fixture(scope="module")
def flights(delivered, tmp_path_factory):
    """Return a function that returns the orders of a campaign, and the paths of its files."""

    def made(keep):
        folder = tmp_path_factory.mktemp("flights")
        path = folder / "campaign.toml"
        path.write_text(CAMPAIGN.format(keep=str(keep).lower(), fmus=delivered))
        orders = prepare(read_campaign(path), folder, lambda _: None)
        places = {n: {file: folder / "files" / file.name for file in orders.files_of(n)} for n in range(1, 5)}
        return orders, places

    return made


def test_kept_fmus_give_the_rows_of_fresh_ones(flights):
    (fresh, places), (kept, others) = flights(False), flights(True)
    expected = [fly(fresh.order(number), places[number]) for number in range(1, 5)]
    found = [fly(kept.order(number), others[number]) for number in (3, 4, 1, 2)]

    assert [one.rows_sha256 for one in found] == [expected[k].rows_sha256 for k in (2, 3, 0, 1)]
    assert [one.metrics for one in found] == [expected[k].metrics for k in (2, 3, 0, 1)]
    assert len({one.rows_sha256 for one in expected}) == 4


def resident(process):
    """Return the memory in use, without what allocators keep for later."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pyarrow.default_memory_pool().release_unused()
    return process.memory_info().rss


def test_memory_descriptors_and_folders_do_not_grow(flights):
    orders, places = flights(True)
    here = psutil.Process()

    def used():
        return here.num_fds(), len(list(unpacking_folder().glob(f"lockstep-*-{os.getpid()}-*")))

    for number in (1, 2, 3, 4, 1, 2):
        fly(orders.order(number), places[number])
    before, memory = used(), [resident(here)]
    for _ in range(2):
        for number in (1, 2) * 5:
            fly(orders.order(number), places[number])
        memory.append(resident(here))

    assert used() == before
    # bytes, of 10 runs; allocators take pages in blocks, now and then: what is lost in each run is lost in both halves
    assert min(memory[1] - memory[0], memory[2] - memory[1]) < 1e6


def test_a_kept_history_is_compressed_and_has_the_rows_of_a_run_without(flights, tmp_path):
    orders, places = flights(True)
    order = orders.order(2)
    bare = fly(order, places[2])
    kept = fly(replace(order, wanted=replace(order.wanted, histories=Histories(kept="all"))), places[2])
    unpack(kept.folder, tmp_path / "run")

    assert (bare.folder, bare.rows_sha256, bare.metrics) == (b"", kept.rows_sha256, kept.metrics)
    assert (tmp_path / "run/signals.parquet").is_file()
    assert not (tmp_path / "run/signals.arrows").exists()
    assert digest_of_all(read_signals(tmp_path / "run")) == bare.rows_sha256
