"""Probes under load: memory over many steps, and the cost of a step."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from lockstep.check.dynamic.checked_instance import PortCall
from lockstep.check.dynamic.experiment import PERIOD
from lockstep.check.dynamic.probe_process import ProbeResult, ProbeTask
from lockstep.errors import RunError
from lockstep.operating_system import resident_memory

MEGABYTE = 2**20
GROWTH_LIMIT = 1.0  # [MB] after the warm-up: allocators move by less than that
SAMPLES = 40
WARM_UP = 0.2  # of the steps
COST_STEPS = 2000


def resident() -> float:
    """Return the resident memory of this process [MB]."""
    return resident_memory() / MEGABYTE


def memory(task: ProbeTask) -> ProbeResult:
    """Make many steps; after a warm-up the resident memory must not grow."""
    aim, seconds = task.options["steps"], task.options["seconds"]
    instance = task.started()
    tables, experiment = instance.stimuli(), task.experiment
    block = max(1, aim // SAMPLES)
    deadline = time.monotonic() + seconds
    sizes, counts, why = [resident()], [0], ""
    done = 0
    while done < aim and not why:
        try:
            for number in range(done, min(done + block, aim)):
                k = number % (experiment.most_steps or aim)
                if number and not k:  # it asks for the end here: begin again
                    instance.reset()  # a new instance would cost this process memory of its own
                    instance.initialise()
                instance.put([table[k % PERIOD] for table in tables])
                instance.step(experiment.time(k), experiment.step)
                instance.row()
        except RunError as error:
            if done < aim * WARM_UP:
                raise
            why = f"; ended by {error}"
            break
        done = min(done + block, aim)
        sizes.append(resident())
        counts.append(done)
        if time.monotonic() > deadline and done < aim:
            why = f"; the time limit of {seconds:g} s ended it before {aim:,} steps"
    return memory_result(np.array(sizes), np.array(counts), why)


def memory_result(sizes: Any, counts: Any, why: str) -> ProbeResult:
    """Judge the growth of memory from resident sizes [MB] after so many steps; `why` is what ended them early."""
    warm = int(np.searchsorted(counts, WARM_UP * counts[-1]))
    steps = int(counts[-1] - counts[warm])
    if not steps:
        return ProbeResult(status="skipped", message=f"only {counts[-1]} steps{why}")
    growth = float(sizes[-1] - sizes[warm])
    middle = (warm + len(sizes)) // 2
    late = float(sizes[-1] - sizes[middle])  # what fills a buffer once has ended by then
    rate = growth * MEGABYTE / steps
    numbers = {"steps": float(counts[-1]), "growth [MB]": growth, "growth [B/step]": rate, "resident [MB]": sizes[-1]}
    message = f"{counts[-1]:,} steps: {growth:+.2f} MB after the first {counts[warm]:,}{why}"
    if growth <= GROWTH_LIMIT:
        return ProbeResult(message=message, numbers=numbers)
    if late < 0.2 * growth:
        return ProbeResult(status="info", message=f"{message}; it has stopped growing", numbers=numbers)
    return ProbeResult(status="error", message=f"{message}, {rate:.0f} bytes a step", numbers=numbers)


def cost(task: ProbeTask) -> ProbeResult:
    """Measure setting, stepping and getting, each step by itself."""
    steps, deadline = task.options["steps"], time.monotonic() + task.options["seconds"]
    instance = task.started()
    tables, experiment = instance.stimuli(), task.experiment
    clock, spent = time.perf_counter_ns, []
    for k in range(min(steps, experiment.most_steps or steps)):
        at, length = experiment.time(k), experiment.step
        for port_call, table in zip(instance.write, tables, strict=True):
            port_call.buffer[:] = table[k % PERIOD]
        moments = [clock()]
        status = _all(instance.write)
        moments.append(clock())
        status |= instance.do_step(at, length, 1)
        moments.append(clock())
        status |= _all(instance.read)
        moments.append(clock())
        if status > 1:
            raise RunError(f"a call failed in step {k + 1}: {instance.logged() or 'it logged nothing'}")
        spent.append(np.diff(moments))
        if time.monotonic() > deadline:
            break
    parts = np.array(spent[len(spent) // 10 :]) * 1e-3
    numbers: dict[str, float] = {}
    for name, column in (("set", parts[:, 0]), ("step", parts[:, 1]), ("get", parts[:, 2]), ("sum", parts.sum(axis=1))):
        numbers[f"{name} median [us]"] = float(np.median(column))
        numbers[f"{name} 99th percentile [us]"] = float(np.percentile(column, 99.0))
    whole = numbers["sum median [us]"]
    message = (
        f"median {whole:.1f} us a step (set {numbers['set median [us]']:.1f}, step {numbers['step median [us]']:.1f}, "
        f"get {numbers['get median [us]']:.1f}), 99th percentile {numbers['sum 99th percentile [us]']:.1f} us; "
        f"{task.experiment.step * 1e6 / whole:.3g} times real time"
    )
    return ProbeResult(status="info", message=message, numbers=numbers)


def _all(bound: list[PortCall]) -> int:
    status = 0
    for port_call in bound:
        status |= port_call.call()
    return status
