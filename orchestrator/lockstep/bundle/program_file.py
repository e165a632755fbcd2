"""Write the program of a bundle as the bytes of `resources/program.bin`, which `c/program_file.c` reads.

All numbers are little-endian: 32 bits for counts, references and positions, 64 for times and Reals. A text, and each
list, begins with its length; a text ends with a zero.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from math import lcm

from lockstep.bundle.contents import CARRIED, Contents
from lockstep.bundle.ports import Port, carried
from lockstep.bundle.program import BundleProgram, ComponentStep, Get, Initial, step_length
from lockstep.bundle.shown import Shown
from lockstep.fmi.fmi3_arrays import start_of
from lockstep.fmi.model_description import Description, Variable
from lockstep.fmi.slave import SCALARS, Scalar
from lockstep.system.component import Value

PROGRAM = "program.bin"
MAGIC = b"LOCKSTEP BUNDLE\x02"
TYPES: tuple[Scalar, ...] = (*CARRIED, "String")
_ENUMERATION = len(TYPES)  # how FMI 3.0 passes one differs from how it lies in the bundle: an Integer
_KINDS = ("input", "output", "parameter", "tunable")
_CONTINUOUS, _EARLY, _SAVES_STATE, _VERSION_3 = 1, 2, 4, 8  # flags of a component


class _Writer:
    def __init__(self) -> None:
        self._parts: list[bytes] = [MAGIC]

    def count(self, value: int) -> None:
        self._parts.append(struct.pack("<I", value))

    def time(self, value: int) -> None:
        self._parts.append(struct.pack("<q", value))

    def real(self, value: float) -> None:
        self._parts.append(struct.pack("<d", value))

    def text(self, value: str) -> None:
        content = value.encode()
        self.count(len(content))
        self._parts += (content, b"\0")

    def counts(self, values: Sequence[int]) -> None:
        self.count(len(values))
        self._parts.append(struct.pack(f"<{len(values)}I", *values))

    def reals(self, values: Sequence[float]) -> None:
        self.count(len(values))
        self._parts.append(struct.pack(f"<{len(values)}d", *values))

    def flags(self, values: Iterable[bool]) -> None:
        self.counts([int(value) for value in values])

    def value(self, scalar: str, value: Value) -> None:
        if scalar == "Real":
            self.real(float(value))
        elif scalar == "String":
            self.text(str(value))
        else:
            self._parts.append(struct.pack("<i", int(value)))

    def done(self) -> bytes:
        return b"".join(self._parts)


def program_bytes(
    contents: Contents, program: BundleProgram, guid: str, folders: Mapping[str, str], variables: Sequence[Shown]
) -> bytes:
    """Return the program file.

    Parameters
    ----------
    contents, program : what to write
    guid : of the bundle
    folders : of each component's FMU below resources/
    variables : what hosts see of the ports, in their order
    """
    out = _Writer()
    out.text(guid)
    tick = contents.system.tick
    parts = lcm(tick.denominator)
    out.time(int(tick * parts))
    out.time(10**9 * parts)
    out.count(contents.step_ticks)
    for sizes in (program.bus, program.slots, program.row_sizes):
        for scalar in CARRIED:
            out.count(sizes.get(scalar, 0))
    _write_components(out, contents, folders)
    _write_ports(out, contents)
    _write_variables(out, variables)
    out.counts(program.order)
    for initial in program.initial:
        _write_initial(out, initial)
    out.count(len(program.steps))
    for step in program.steps:
        _write_step(out, step)
    out.count(len(program.rows))
    for row in program.rows:
        for scalar in CARRIED:
            out.counts(row.get(scalar, ()))
    out.count(len(program.ticks))
    for one in program.ticks:
        out.counts(one.early)
        out.counts(one.late)
        out.count(one.row + 1)
    return out.done()


def _write_components(out: _Writer, contents: Contents, folders: Mapping[str, str]) -> None:
    tasks = {task.name: task for task in contents.layout.schedule.tasks}
    out.count(len(contents.system.components))
    for component in contents.system.components:
        description, task = contents.descriptions[component.name], tasks[component.name]
        out.text(component.name)
        out.text(folders[component.name])
        out.text(description.identifier)
        out.text(description.guid)
        states = _SAVES_STATE if description.saves_state else 0
        early = 0 if task.continuous or task.after_row else _EARLY
        third = _VERSION_3 if description.version == "3.0" else 0
        out.count((_CONTINUOUS if task.continuous else 0) | early | states | third)
        out.count(task.period)
        out.count(task.offset)
        out.real(step_length(contents, task))
        out.real(description.tolerance_of(component) or 0.0)
        if third:
            _write_arrays(out, description)
        starts = contents.starts(component.name)
        for scalar in TYPES:
            values = sorted(starts.get(scalar, {}).items())
            out.counts([reference for reference, _ in values])
            for _, value in values:
                out.value(scalar, value)
        _write_names(out, contents, component.name)


def _write_arrays(out: _Writer, description: Description) -> None:
    """Write the arrays of an FMU of FMI 3.0 by type: those first that can be set, with their start values."""
    variables = description.variables.values()
    out.count(1 + max((v.reference for v in variables), default=0))
    for scalar in TYPES:
        arrays: dict[int, list[Variable]] = {}
        for variable in variables:
            if variable.scalar == scalar and carried(variable):
                arrays.setdefault(variable.array, []).append(variable)
        for members in arrays.values():
            members.sort(key=lambda variable: variable.element)
        listed = sorted(arrays.items(), key=lambda item: (not item[1][0].settable, item[1][0].reference))
        out.counts([handle for handle, _ in listed])
        out.counts([members[0].reference for _, members in listed])
        out.counts([len(members) for _, members in listed])
        starts = [start_of(variable) for _, members in listed if members[0].settable for variable in members]
        out.count(len(starts))
        for value in starts:
            out.value(scalar, value)


def _write_names(out: _Writer, contents: Contents, name: str) -> None:
    """Write the names of the inputs and outputs that connections transfer, for messages."""
    links = contents.layout.links
    for scalar in CARRIED:
        used = {r for link in links if link.scalar == scalar and link.producer == name for r in link.sources}
        used |= {r for link in links if link.scalar == scalar and link.consumer == name for r in link.targets}
        variables = contents.descriptions[name].variables.values()
        names = {v.reference: v.name for v in variables if v.scalar == scalar and v.causality != "local"}
        chosen = sorted(used)
        out.counts(chosen)
        for reference in chosen:
            out.text(names.get(reference, f"reference {reference}"))


def _write_ports(out: _Writer, contents: Contents) -> None:
    numbers = {component.name: k for k, component in enumerate(contents.system.components)}
    places = dict.fromkeys(SCALARS, 0)  # of outputs in a row
    out.count(len(contents.ports))
    for port in contents.ports:
        scalar = port.variable.scalar
        assert scalar is not None
        out.count(_KINDS.index(_kind(port)))
        out.count(TYPES.index(scalar))
        if port.kind == "output":
            out.count(places[scalar])
            places[scalar] += 1
        else:
            assert port.start is not None
            out.value(scalar, port.start)
        out.count(len(port.ends))
        for end in port.ends:
            out.count(numbers[end.component])
            out.count(end.variable.reference)
            out.real(end.gain)
            out.real(end.bias)


def _write_variables(out: _Writer, variables: Sequence[Shown]) -> None:
    out.count(len(variables))
    for variable in variables:
        first = variable.first.variable
        assert first.scalar is not None
        out.count(len(variable.ports))
        out.count(_ENUMERATION if first.type == "Enumeration" else TYPES.index(first.scalar))


def _kind(port: Port) -> str:
    return "tunable" if port.kind == "parameter" and port.variable.variability == "tunable" else port.kind


def _write_initial(out: _Writer, initial: Initial) -> None:
    out.count(len(initial.sets))
    for one in initial.sets:
        out.count(one.producer)
        out.count(TYPES.index(one.scalar))
        out.counts(one.targets)
        out.counts(one.slots)
        out.reals(one.gains)
        out.reals(one.biases)
    _write_gets(out, initial.gets)
    _write_gets(out, initial.bus)


def _write_step(out: _Writer, step: ComponentStep) -> None:
    out.count(step.component)
    out.count(len(step.sets))
    for one in step.sets:
        out.count(TYPES.index(one.scalar))
        out.counts(one.targets)
        out.counts(one.positions)
        out.reals(one.gains)
        out.reals(one.biases)
    _write_gets(out, step.gets)


def _write_gets(out: _Writer, gets: Sequence[Get]) -> None:
    out.count(len(gets))
    for one in gets:
        out.count(TYPES.index(one.scalar))
        out.counts(one.references)
        out.count(one.start)
        out.flags(one.used)
