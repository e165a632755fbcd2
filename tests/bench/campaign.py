"""Cost of a campaign's runs: processor time of a run of 300 s with reduced recording, and growth over many short runs.

    .venv/bin/python tests/bench/campaign.py examples/campaigns/layouts.toml          # processor time, by layout
    .venv/bin/python tests/bench/campaign.py examples/campaigns/short.toml --runs 1000    # memory, descriptors, folders
    .venv/bin/python tests/bench/campaign.py examples/campaigns/layouts.toml --workers    # rate of two workers over one

All in one process but with --workers: a campaign of 60 cases, or as many as --cases, with one worker and with two, from
the call to the results. Processor times hold on a loaded machine; rates do not.
"""

import argparse
import ctypes
import dataclasses
import gc
import os
import re
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil
import pyarrow
import pyarrow.parquet as pq

from flexbench.campaign.campaign import run_campaign
from flexbench.campaign.campaign_file import read_campaign
from flexbench.campaign.flight import fly
from flexbench.campaign.orders import prepare
from flexbench.campaign.result_file import TIMINGS, read_results
from flexbench.engine.pools import LocalPool
from lockstep.fmi.temporary_folder import unpacking_folder


def orders_of(path, folder):
    """Return the orders of a campaign file and a function that flies one, for a shorter time if one is given."""
    orders = prepare(read_campaign(path), folder, print)
    places = {name: {file: folder / "files" / file.name for file in (stored.system, *stored.files)}
              for name, stored in orders.systems.items()}  # fmt: skip

    def flown(number, stop_time=None):
        order = orders.order(number)
        if stop_time is not None:
            order = dataclasses.replace(order, wanted=dataclasses.replace(order.wanted, stop_time=stop_time))
        return fly(order, places[orders.case_of(number)[1]])

    return orders, flown


def cost(orders, flown):
    """Print the processor time of a run of each system."""
    systems = len(orders.names)
    for number in range(1, systems + 1):
        flown(number, 0.1)  # FMUs are unpacked and loaded
    for repeat in range(2):
        for number in range(1 + repeat * systems, 1 + (repeat + 1) * systems):
            before, wall = time.process_time(), time.perf_counter()
            found = flown(number)
            used, passed = time.process_time() - before, time.perf_counter() - wall
            name = orders.case_of(number)[1]
            print(f"{name}: {found.simulated_time:g} s in {used:.2f} s of processor time ({passed:.2f} s of wall time)")


def growth(flown, runs, total):
    """Print memory, descriptors and folders over many short runs."""
    here = psutil.Process()
    for number in range(runs + 1):
        flown(number % total + 1, 0.1)
        if number in (20, runs) or number % 100 == 0:
            folders = len(list(unpacking_folder().glob(f"lockstep-*-{os.getpid()}-*")))
            gc.collect()
            ctypes.CDLL(None).malloc_trim(0)  # what the C library keeps for later is not in use
            pyarrow.default_memory_pool().release_unused()
            memory = here.memory_info().rss / 1e6
            print(f"{number} runs: {memory:.2f} MB, {here.num_fds()} descriptors, {folders} folders", flush=True)


def with_cases(path, cases, folder):
    """Write a campaign file with another number of cases, and its relative paths made absolute; return its path."""
    text = re.sub(r'"(\.[^"]*)"', lambda found: f'"{(path.parent / found[1]).resolve()}"', path.read_text())
    text, count = re.subn(r"(?m)^cases = .*$", f"cases = {cases}", text)
    if count != 1:
        raise SystemExit(f"{path}: has no line `cases = ...`")
    written = folder / path.name
    written.write_text(text)
    return written


def rate_between(folder):
    """Return the runs in a second from the time at which each worker has ended one to the last result."""
    timings = pq.read_table(folder / TIMINGS)
    ended, names = timings["ended"].to_numpy(), np.array(timings["worker"].to_pylist())
    begin = max(ended[names == name].min() for name in set(names))
    return np.count_nonzero(ended > begin) / (ended.max() - begin)


def workers(path, folder):
    """Print the rates of one and two workers, with their start and without, and the processor time of a run."""
    rates = []
    for size in (1, 2):
        before, used = time.perf_counter(), os.times()
        out = folder / str(size)
        run_campaign(path, out, lambda settings, size=size: LocalPool(settings, size), lambda _: None)
        passed, after = time.perf_counter() - before, os.times()
        runs = len(read_results(out).numbers)
        rates.append((runs / passed, rate_between(out)))
        of_workers = after.children_user + after.children_system - used.children_user - used.children_system
        own = after.user + after.system - used.user - used.system
        print(f"{size} workers: {runs} runs in {passed:.1f} s, {rates[-1][0]:.4f} a second, {rates[-1][1]:.4f} from the"
              f" first results to the last; processor time of a run {of_workers / runs:.3f} s, of the campaign itself"
              f" {own:.1f} s; load {os.getloadavg()[0]:.1f}", flush=True)  # fmt: skip
    whole, between = (two / one for one, two in zip(*rates, strict=True))
    print(f"two workers over one: {whole:.3f} with start and end, {between:.3f} between")


def main():
    """Measure what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("campaign", type=Path)
    parser.add_argument("--runs", type=int)
    parser.add_argument("--workers", action="store_true")
    parser.add_argument("--cases", type=int, default=60, help="with --workers; each is simulated with every system")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        if given.workers:
            workers(with_cases(given.campaign, given.cases, Path(name)), Path(name))
            return
        orders, flown = orders_of(given.campaign, Path(name))
        if given.runs is None:
            cost(orders, flown)
        else:
            growth(flown, given.runs, len(orders))


if __name__ == "__main__":
    main()
