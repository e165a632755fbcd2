"""Read files of signals for inputs: a column `time` in seconds, and one column for each input that the file gives.

A column is named as the input, `component.variable`, or as a connector of the system, or, if the system is one FMU, by
the variable alone. Between two rows the inputs that are continuous Reals are interpolated linearly and all others keep
the value of the row before; before the first row they have its values, after the last row the values of that. Of rows
with the same time the last one counts from it on. Values are in the unit of the input or connector, unless the column
states one, which is converted: as exported results do, `plant.rate [deg/s]` in CSV and `unit` in Parquet's metadata.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import Description, Variable
from lockstep.fmi.parameter_values import parse_value
from lockstep.fmi.slave import DTYPES, Scalar
from lockstep.results.table_file import TIME, Table, TableFile, open_table, table_digest
from lockstep.system.component import Value
from lockstep.system.system import System, SystemInput
from lockstep.system.transformation import Conversion, End, Hop, convert, family
from lockstep.system.unit_table import UNITS, gain_between
from lockstep.system.units import Unit

SAME_TIME = 5e-10  # [s]: the master counts nanoseconds, and times in files are often sums of steps

Paths = Path | str | Sequence[Path | str]
Target = tuple[str, str]  # component and input


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column and one of the inputs that it feeds; `hops` lead there from a connector of the system."""

    name: str
    component: str
    variable: Variable
    unit: Unit | None  # of the values, if the file states none
    hops: tuple[Hop, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class InputFile:
    """A file and the inputs that its columns feed."""

    table: TableFile
    columns: tuple[Column, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class InputPart:
    """The inputs of one component and type from one file, all `linear` or all held. `values` are (rows, inputs)."""

    component: str
    scalar: Scalar
    linear: bool
    references: tuple[int, ...]
    times: Sequence[float]  # [s], ascending
    values: NDArray[Any]
    tolerance: float = SAME_TIME  # [s]


def open_inputs(paths: Paths, system: System, descriptions: Mapping[str, Description]) -> tuple[InputFile, ...]:
    """Return the files and what each of their columns feeds, or raise InputError."""
    files = [paths] if isinstance(paths, str | Path) else paths
    return tuple(_open(Path(path).absolute(), system, descriptions) for path in files)


def fed_inputs(files: Iterable[InputFile]) -> dict[Target, str]:
    """Return which file feeds which input; InputError for one that two columns feed."""
    found: dict[Target, str] = {}
    for file in files:
        for column in file.columns:
            key, source = (column.component, column.variable.name), f"{file.table}: column {column.name}"
            if key in found:
                raise InputError(f"{source}: {'.'.join(key)} is fed by {found[key]} already; remove one of them")
            found[key] = source
    return found


def unchanged(entries: Iterable[Mapping[str, Any]]) -> list[Path]:
    """Return the files of an earlier run, as its run.toml lists them; InputError if one has changed since."""
    for entry in entries:
        path = Path(entry["path"])
        if (now := table_digest(path)) != entry["sha256"]:
            hashes = f"sha256 {entry['sha256'][:12]} then, {now[:12]} now"
            raise InputError(f"{path}: has changed since the run, {hashes}; restore the old one")
    return [Path(entry["path"]) for entry in entries]


def listed(files: Iterable[InputFile]) -> list[dict[str, object]]:
    """Return what run.toml says of the files."""
    tables = [file.table for file in files]
    return [{"path": str(t.path), "sha256": t.sha256, "columns": [n for n in t.names if n != TIME]} for t in tables]


def read_inputs(files: Iterable[InputFile]) -> tuple[InputPart, ...]:
    """Read the values, in the types and units of the inputs, or raise InputError."""
    return tuple(part for file in files for part in _parts(file))


def _open(path: Path, system: System, descriptions: Mapping[str, Description]) -> InputFile:
    table = open_table(path)
    names = [name for name in table.names if name != TIME]
    if not names:
        raise InputError(f"{table}: has no column beside {TIME}; name each as an input, component.variable")
    columns = [column for name in names for column in _targets(name, str(table), system, descriptions)]
    return InputFile(table=table, columns=tuple(columns))


def _targets(name: str, file: str, system: System, descriptions: Mapping[str, Description]) -> list[Column]:
    connector = next((one for one in system.inputs if one.name == name), None)
    if connector is not None:
        return [
            _fed(name, file, connector, feed.component, feed.input, feed.hops, descriptions) for feed in connector.feeds
        ]
    component, dot, variable = name.partition(".")
    if not (dot and component in descriptions) and len(system.components) == 1:
        component, variable = system.components[0].name, name
    if component not in descriptions:
        known = [one.name for one in system.inputs] + [
            f"{c}.{v.name}" for c, d in descriptions.items() for v in d.variables.values() if v.causality == "input"
        ]
        raise InputError(f"{file}: column {name}: no such input; there are {compact(known)}{suggestion(name, known)}")
    return [_fed(name, file, None, component, variable, (), descriptions)]


def _fed(
    name: str,
    file: str,
    connector: SystemInput | None,
    component: str,
    key: str,
    hops: tuple[Hop, ...],
    descriptions: Mapping[str, Description],
) -> Column:
    description = descriptions[component]
    variable = description.variables.get(key)
    if variable is None:
        raise InputError(f"{file}: column {name}: {description.lacks(component, key, 'input')}")
    if variable.causality != "input" or variable.scalar is None:
        what = variable.causality if variable.scalar is not None else f"{variable.causality} of type {variable.type}"
        remedy = "; --set gives a parameter one value" if variable.causality == "parameter" else ""
        raise InputError(f"{file}: column {name}: is the FMU's {what}, and files feed inputs only{remedy}")
    unit = variable.unit if connector is None else connector.unit
    return Column(name=name, component=component, variable=variable, unit=unit, hops=hops)


def _parts(file: InputFile) -> list[InputPart]:
    table = file.table.read({TIME, *(column.name for column in file.columns if column.variable.scalar == "Real")})
    times = table.times()
    groups: dict[tuple[str, Scalar, bool], list[tuple[int, NDArray[Any]]]] = {}
    for column in file.columns:
        variable = column.variable
        assert variable.scalar is not None
        linear = variable.scalar == "Real" and variable.variability == "continuous"
        key = (column.component, variable.scalar, linear)
        groups.setdefault(key, []).append((variable.reference, _values(table, column)))
    return [
        InputPart(
            component=component,
            scalar=scalar,
            linear=linear,
            references=tuple(reference for reference, _ in entries),
            times=times.tolist(),
            values=np.column_stack([values for _, values in entries]),
        )
        for (component, scalar, linear), entries in groups.items()
    ]


def _values(table: Table, column: Column) -> NDArray[Any]:
    variable, what = column.variable, f"{table.file}: column {column.name}"
    conversion = _conversion(table, column, what)
    if variable.scalar == "Real":
        reals = table.numbers(column.name)
        if (conversion.gain, conversion.bias) != (1.0, 0.0):
            reals = conversion.gain * reals + conversion.bias
        for extreme in (reals.min(), reals.max()):
            parse_value(float(extreme), variable, what)  # finite, and in the range of the FMU
        return reals
    known: dict[Any, Value] = {}
    values = table.python_values(column.name)
    for row, given in enumerate(values):
        if given not in known:
            known[given] = _value(given, column, conversion, f"{table.file}: row {row + 1}: {column.name}")
    assert variable.scalar is not None
    found = [known[given] for given in values]
    return np.array(found, DTYPES[variable.scalar])


def _conversion(table: Table, column: Column, what: str) -> Conversion:
    """Return how the values in the file become those of the input."""
    variable = column.variable
    stated = table.file.units.get(column.name, "") if variable.scalar == "Real" else ""
    target = variable.end(variable.unit)
    tables = [hop.table.kind for hop in column.hops if hop.table is not None]
    source = End(type=tables[0] if tables else family(variable.type), unit=column.unit, items=variable.items)
    found = (
        convert(replace(source, relative=variable.relative), target, column.hops, what) if column.hops else Conversion()
    )
    try:
        gain, bias = gain_between(
            UNITS.get(stated, Unit(name=stated)) if stated else None, column.unit, variable.relative
        )
    except ValueError as error:
        raise InputError(f"{what}: {error}; correct the unit of the column") from None
    return replace(found, gain=found.gain * gain, bias=found.gain * bias + found.bias)


def _value(given: Any, column: Column, conversion: Conversion, what: str) -> Value:
    """Return a value that is no Real in the type of its input; whole numbers may be written as 1.0, flags as 0 or 1."""
    variable = column.variable
    if given is None:
        raise InputError(f"{what}: is empty")
    if variable.type != "String":
        given = _plain(given, variable)
    function = conversion.function
    if function is None:
        return parse_value(given, variable, what)
    start = replace(variable, type="Boolean") if isinstance(given, bool) else replace(variable, type="Integer")
    sent = function(int(parse_value(given, replace(start, minimum=None, maximum=None), what)))
    return parse_value(bool(sent) if variable.type == "Boolean" else sent, variable, what)


def _plain(given: Any, variable: Variable) -> Any:
    if isinstance(given, str):
        given = given.strip()
        try:
            number = float(given)
        except ValueError:
            return given
        if "." not in given and "e" not in given.lower():
            given = int(given) if number.is_integer() else given
        elif number.is_integer():
            given = int(number)
    if variable.type == "Boolean" and not isinstance(given, str) and given in (0, 1):
        return bool(given)
    return given
