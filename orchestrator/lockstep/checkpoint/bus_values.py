"""Save and restore the bus by component, output and version, as another run may lay it out differently."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.checkpoint.file import Arrays, Checkpoint
from lockstep.errors import InputError
from lockstep.fmi.slave import SCALARS, Scalar
from lockstep.plan.bus_layout import Layout
from lockstep.plan.plan import Plan
from lockstep.plan.schedule import Task
from lockstep.run.exchange import Exchange

ReadPresent = Callable[[str, Scalar, list[int]], NDArray[Any]]  # outputs of a component as they are now
Outputs = dict[str, dict[str, list[str]]]  # names by component and type
Readers = dict[tuple[str, int, Scalar, int], set[str]]  # by component, version, type and reference


def held_versions(layout: Layout, task: Task, tick: int) -> range:
    """Return the versions of a component's outputs that the bus holds before a tick."""
    newest = task.begun(tick - 1)
    return range(newest - layout.rings[task.name] + 1, newest + 1)


def saved_bus(plan: Plan, exchange: Exchange, tick: int) -> tuple[dict[str, NDArray[Any]], Outputs]:
    """Return the values on the bus before a tick, as arrays, and the names of the outputs that they index."""
    arrays: dict[str, NDArray[Any]] = {}
    outputs: Outputs = {}
    for task in plan.schedule.tasks:
        for scalar in SCALARS:
            versions, references, values = [], [], []
            for version in held_versions(plan.layout, task, tick):
                start, fetched = plan.layout.fetched(task.name, scalar, version)
                versions += [version] * len(fetched)
                references += fetched
                values.append(exchange.bus[scalar][start : start + len(fetched)])
            if not versions:
                continue
            order = sorted(set(references))
            names = [plan.names[task.name, scalar, reference] for reference in order]
            outputs.setdefault(task.name, {})[scalar] = names
            key = f"bus/{task.name}/{scalar}"
            arrays[f"{key}/version"] = np.array(versions, np.int64)
            arrays[f"{key}/output"] = np.searchsorted(order, references).astype(np.int32)
            joined = np.concatenate(values)
            arrays[f"{key}/value"] = joined.astype(np.str_) if scalar == "String" else joined
    return arrays, outputs


def restore_bus(
    checkpoint: Checkpoint, plan: Plan, exchange: Exchange, present: ReadPresent, reinitialised: Collection[str]
) -> None:
    """Fill the slots of the components that are not reinitialised.

    A value that the checkpoint lacks, since the other run read fewer outputs, is the present output of its producer
    where that is the version needed, or where only a reinitialised component reads it.

    Raises
    ------
    InputError
        If an older value would be recorded that the checkpoint lacks.
    """
    tick, layout = checkpoint.tick, plan.layout
    held = dict(_held(checkpoint.arrays, checkpoint.header["outputs"]))
    readers = _read_later(layout, tick)
    for task in plan.schedule.tasks:
        if task.name in reinitialised:
            continue
        newest = task.begun(tick - 1)
        for scalar in SCALARS:
            for version in held_versions(layout, task, tick):
                start, references = layout.fetched(task.name, scalar, version)
                lacking: dict[int, int] = {}  # positions by reference
                for position, reference in enumerate(references, start):
                    output = plan.names[task.name, scalar, reference]
                    used_by = readers.get((task.name, version, scalar, reference))
                    if (task.name, scalar, version, output) in held:
                        exchange.bus[scalar][position] = held[task.name, scalar, version, output]
                    elif used_by:
                        lacking[reference] = position
                        if version != newest and used_by - set(reinitialised):
                            raise InputError(
                                f"{task.name}.{output}: {checkpoint.path.name} lacks an earlier value of it, which "
                                "would be read; record what the other run recorded"
                            )
                if lacking:
                    values = present(task.name, scalar, list(lacking))
                    exchange.bus[scalar][list(lacking.values())] = values


def _held(arrays: Arrays, outputs: Mapping[str, Mapping[str, list[str]]]) -> Iterator[tuple[Any, Any]]:
    for component, by_type in outputs.items():
        for scalar, names in by_type.items():
            key = f"bus/{component}/{scalar}"
            columns = (arrays[f"{key}/{part}"] for part in ("version", "output", "value"))
            for version, output, value in zip(*columns, strict=True):
                yield (component, scalar, int(version), names[output]), value


def _read_later(layout: Layout, tick: int) -> Readers:
    """Return the values made before a tick that are read from it on, with their readers; "" is the recorder."""
    groups: dict[tuple[str, int, int], set[str]] = {}  # by component, version and number of the group
    for later in range(tick, tick + layout.cycle):
        for producer, reader, version, number in layout.reads(later):
            if version <= producer.begun(tick - 1):
                groups.setdefault((producer.name, version, number), set()).add(reader.name if reader else "")
    found: Readers = {}
    for (producer_name, version, number), names in groups.items():
        for scalar, reference in layout.groups[number]:
            found.setdefault((producer_name, version, scalar, reference), set()).update(names)
    return found
