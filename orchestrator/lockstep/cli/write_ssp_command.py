"""Write a system with replaced components as standard SSP: what an adapter does becomes connections and parameters."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from lockstep.adapter.component import with_replacements
from lockstep.adapter.plain import Mapped, Plain, without_adapter
from lockstep.cli.run_options import with_delays, with_periods
from lockstep.errors import InputError
from lockstep.ssp.load import load_system
from lockstep.ssp.write_package import Entry, ParameterFile, package
from lockstep.system.system import System

WRITE_EXAMPLE = """write-ssp fmus/centralised/fine_pointing.ssd --replace controller=vendor.fmu \\
      --adapter vendor.toml --source star_tracker.mrp=sensors.star_tracker.quaternion --out vendor.ssp

  What the adapter says becomes connections (names, order), linear transformations on them (unit, scale, offset, sign),
  mapping transformations (flags), a parameter mapping .ssm (values of ours for names of theirs) and values .ssv
  (constants, parameters). SSP cannot mix elements (MRP to quaternion, frames that are not signed permutations) nor hold
  values. Such entries are named, and the system is refused (exit code 2), or written without them with --partial."""


def add_write_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `write-ssp`."""
    parser.add_argument("system", type=Path, help="a .ssd file, an unpacked SSP folder, or a .ssp archive")
    parser.add_argument("--replace", action="append", default=[], metavar="C=FMU", help="put an FMU in C's place")
    parser.add_argument("--adapter", action="append", default=[], metavar="FILE",
                        help="TOML file between it and the ports of C; C=FILE if several are replaced")  # fmt: skip
    parser.add_argument("--source", action="append", default=[], metavar="ARRAY=C.ARRAY",
                        help="outputs of C that hold, as a scalar-last quaternion (body from inertial), the attitude "
                             "that ours of an adapter holds as an MRP")  # fmt: skip
    parser.add_argument("--delay", action="append", default=[], metavar="A:B=N", help="delay from A to B in ticks")
    parser.add_argument("--period", action="append", default=[], metavar="C=S", help="period of component C in seconds")
    parser.add_argument("--partial", action="store_true", help="leave out what SSP cannot say, and name it")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help=".ssp to write")


def write_as_told(options: argparse.Namespace) -> int:
    """Write the .ssp with the options of `add_write_options`; say what is left out. Raises InputError."""
    if options.out.suffix != ".ssp":
        raise InputError(f"--out {options.out}: a system package ends with .ssp")
    system = with_replacements(load_system(options.system), options.replace, options.adapter)
    system = with_periods(with_delays(system, options.delay), options.period)
    sources = _sources(options.source)
    content, problems = standard_package(system, sources)
    for problem in problems:
        print(f"{'left out' if options.partial else 'not in SSP'}: {problem}", file=sys.stderr)
    if problems and not options.partial:
        number = f"{len(problems)} thing{'s' if len(problems) > 1 else ''}"
        raise InputError(
            f"{options.out}: not written: SSP cannot say {number} of an adapter; --partial leaves them out"
        )
    try:
        options.out.parent.mkdir(parents=True, exist_ok=True)
        part = options.out.with_name(f".{options.out.name}.{os.getpid()}")
        part.write_bytes(content)
        part.replace(options.out)
    except OSError as error:
        raise InputError(f"{options.out}: cannot be written ({error.strerror or error})") from None
    print(options.out)
    return 0


def standard_package(system: System, sources: Mapping[str, tuple[str, str]]) -> tuple[bytes, tuple[str, ...]]:
    """Return the .ssp of a system without its adapters, and line by line what of them it lacks.

    Raises
    ------
    InputError
        If an adapter does not fit, a source is not there, or an FMU cannot be read.
    """
    files: list[ParameterFile] = []
    problems: list[str] = []
    adapted = [component.name for component in system.components if component.adapter is not None]
    if sources and not adapted:
        raise InputError(f"--source {next(iter(sources))}: needs --replace and --adapter beside it")
    for name in adapted:
        plain = without_adapter(system, name, sources)
        system = plain.system
        problems += plain.problems
        files += _files(plain)
    return package(system, files), tuple(problems)


def _files(plain: Plain) -> list[ParameterFile]:
    """Return all values by names of theirs, and those of ours by names of ours with the mapping.

    Later bindings win, so the second file is the one to edit. The first has what it comes to, for tools that read no
    mapping, as libcosim and ecos: they apply the set of the usual name.
    """
    name = plain.component
    resolved = plain.values | {one.theirs: one.resolved for one in plain.mapped}
    return [
        ParameterFile(
            component=name, name=f"{name}_theirs", values={key: (value, None) for key, value in resolved.items()}
        ),
        ParameterFile(
            component=name,
            name=f"{name}_ours",
            set_name="valuesOfOurs",
            values={one.ours: (one.value, one.unit) for one in plain.mapped},
            mapping=tuple(_entry(one) for one in plain.mapped),
        ),
    ]


def _entry(one: Mapped) -> Entry:
    pair = one.pair
    return Entry(source=one.ours, target=one.theirs, factor=pair.factor, offset=pair.offset, table=pair.table)


def _sources(texts: Iterable[str]) -> dict[str, tuple[str, str]]:
    found: dict[str, tuple[str, str]] = {}
    for text in texts:
        match = re.fullmatch(r"([^=]+)=([^.=]+)\.([^=]+)", text)
        if match is None:
            raise InputError(
                f"--source {text}: write ARRAY=COMPONENT.ARRAY, for example "
                "star_tracker.mrp=sensors.star_tracker.quaternion"
            )
        found[match[1]] = (match[2], match[3])
    return found
