"""Options that commands share: one name, one type and one explanation for one thing."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import wraps
from typing import Any

import click

from lockstep.cli.parameter_types import COUNT, DURATION, NUMBER, PATH
from lockstep.errors import InputError

Function = Callable[..., Any]
Decorator = Callable[[Function], Function]

system_argument = click.argument(
    "system",
    type=PATH,
    metavar="SYSTEM",
    help="a .ssd file, an unpacked SSP folder, a .ssp archive, an OspSystemStructure.xml, or one FMU",
)
results_argument = click.argument("results", type=PATH, nargs=-1, required=True, metavar="RESULTS...",
                                  help="results folders of runs")  # fmt: skip
delay_option = click.option("--delay", multiple=True, metavar="A:B=N", help="delay from A to B in ticks")
step_size_option = click.option(
    "--step-size", multiple=True, metavar="C=S", help="co-simulation step of component C in seconds"
)
replace_option = click.option("--replace", multiple=True, metavar="C=FMU", help="replace component C by another FMU")
adapter_option = click.option(
    "--adapter",
    multiple=True,
    metavar="FILE",
    help="TOML file between the new FMU and the ports of C; C=FILE if several are replaced",
)
set_option = click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="C.P=V",
    help="set parameter P of component C; a number may have a unit: 0.1arcsec",
)
input_option = click.option(
    "--input", "inputs", type=PATH, multiple=True, metavar="FILE",
    help="CSV or Parquet file of input signals: a column `time` in seconds, the others named C.INPUT",
)  # fmt: skip
record_option = click.option(
    "--record", multiple=True, metavar="PATTERN",
    help="outputs to record, `all` for all (default: the system's); and variables by their names, `locals:plant.*`, "
         "`inputs:*`, `parameters:*`",
)  # fmt: skip
reinitialise_option = click.option(
    "--reinitialise", multiple=True, metavar="C",
    help="initialise component C again instead of restoring its state: for another FMU, or other fixed parameters",
)  # fmt: skip
DISTINGUISHED = ", -2, -3 and so on if that is taken"  # how a command names a folder of its own
jobs_option = click.option("--jobs", type=COUNT, metavar="N", help="parallel processes (default: one a core)")


def stop_time_option(default: float | None, text: str = "simulated time in seconds") -> Decorator:
    """Return the option of the stop time; without a default it is that of the system or the earlier run."""
    shown = "" if default is None else f" (default: {default:g})"
    return click.option("--stop-time", type=DURATION, default=default, metavar="S", help=text + shown)


def out_option(text: str, default: str | None = None, metavar: str = "DIR", required: bool = False) -> Decorator:
    """Return the option of the folder or file to write."""
    if required:  # click takes a default of None for a value
        return click.option("--out", type=PATH, metavar=metavar, required=True, help=text)
    shown = f"{text} (default: {default})" if default else text
    return click.option("--out", type=PATH, default=default, metavar=metavar, help=shown)


def from_option(text: str) -> Decorator:
    """Return the option of the time from which results are evaluated."""
    return click.option("--from", "start", type=NUMBER, metavar="S", help=text)


def option_group(name: str, values: type, *options: Decorator) -> Decorator:
    """Return a decorator that adds options to a command and gives it their values as one object.

    Parameters
    ----------
    name : of the command's argument that takes the object
    values : class of the object, a dataclass with one field for each option, or for each group among the options
    options : decorators, in the order of the help
    """
    fields = tuple(values.__dataclass_fields__)  # type: ignore[attr-defined]

    def decorate(function: Function) -> Function:
        @wraps(function)
        def call(**given: Any) -> Any:
            group = values(**{field: given.pop(field) for field in fields})
            return function(**given, **{name: group})

        decorated: Function = call
        for option in reversed(options):
            decorated = option(decorated)
        return decorated

    return decorate


def assignments(texts: Iterable[str]) -> dict[str, str]:
    """Return values given as COMPONENT.PARAMETER=VALUE, by component and parameter."""
    values: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not (key and equals):
            raise InputError(f"--set {text}: write COMPONENT.PARAMETER=VALUE")
        if values.setdefault(key, value) != value:
            raise InputError(f"--set {text}: is {values[key]} already; give one value for {key}")
    return values


def refuse_repeated(texts: Iterable[str], option: str) -> None:
    """Raise InputError for an option, given as KEY=VALUE, that has two values for one key."""
    values: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.rpartition("=")
        if equals and values.setdefault(key, value) != value:
            raise InputError(f"{option} {text}: is {values[key]} already; give one value for {key}")
