"""The values of an input: a distribution of scipy.stats by name, a list, or the number of the case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from typing import Any

import numpy as np
import scipy.stats

from flexsat.arrays import Array
from lockstep.errors import InputError, suggestion

from .toml_values import flag_of

Value = float | int | bool | str
CASE = "case"  # distribution: the number of the case, for seeds
_OWN = ("distribution", "values", "nominal", "round")


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """Where values come from. Without distribution and list they are a column of a table."""

    distribution: str = ""
    parameters: tuple[tuple[str, float], ...] = ()
    values: tuple[Value, ...] = ()
    nominal: Value | None = None  # of the other inputs' cases, one at a time
    whole: bool = False  # rounded to whole numbers

    @property
    def discrete(self) -> bool:
        """Whether it has values of its own instead of a range."""
        return bool(self.values) or self.distribution == CASE

    @property
    def text(self) -> str:
        """The distribution in words."""
        if self.values:
            return f"one of {', '.join(map(str, self.values))}"
        if self.distribution == CASE:
            return "number of the case"
        inside = ", ".join(f"{name}={value:g}" for name, value in self.parameters)
        return f"{self.distribution}({inside})" if self.distribution else "column of the table"

    def at(self, share: Array) -> list[Value]:
        """Return the values at shares of the distribution.

        Parameters
        ----------
        share : (cases,) between 0 and 1
        """
        if self.values:
            return [self.values[min(int(one * len(self.values)), len(self.values) - 1)] for one in share]
        if self.distribution == CASE:
            return list(range(1, len(share) + 1))
        found = np.asarray(self._frozen().ppf(share), dtype=float)
        if self.whole or not hasattr(getattr(scipy.stats, self.distribution), "pdf"):
            return [round(one) for one in found.tolist()]
        return list(found.tolist())

    def check(self, sampling: str, where: str) -> None:
        """Raise InputError if a sampling needs something else."""
        if sampling == "table":
            if self.distribution or self.values:
                raise InputError(f"{where}: its values are in the table; leave the distribution out")
        elif sampling in ("grid", "one-at-a-time"):
            if not self.values:
                raise InputError(f"{where}: values: missing; {sampling} needs a list")
            if sampling == "one-at-a-time" and self.nominal is None:
                raise InputError(f"{where}: nominal: missing; it holds while others vary")
        elif not self.discrete and not self.distribution:
            raise InputError(f"{where}: distribution: missing; name one of scipy.stats, or give values")
        if sampling == "saltelli" and self.distribution == CASE:
            raise InputError(
                f"{where}: distribution = {CASE!r}: Sobol indices need a range; give uniform with round = true, or one"
                " value for all under [set]"
            )
        if self.nominal is not None and sampling != "one-at-a-time":
            raise InputError(
                f"{where}: nominal = {self.nominal!r}: has an effect with one-at-a-time only; leave it out"
            )

    def _frozen(self) -> Any:
        return getattr(scipy.stats, self.distribution)(**dict(self.parameters))


def read_drawn(entry: Mapping[str, Any], where: str) -> Drawn:
    """Return the values of an input from what its table says of them; InputError for what is wrong."""
    name = entry.get("distribution", "")
    values = entry.get("values", [])
    parameters = {key: value for key, value in entry.items() if key not in _OWN}
    whole = flag_of(entry, "round", where, False)
    if "round" in entry and (not name or name == CASE):
        raise InputError(f"{where}: round: has an effect with a distribution of scipy.stats only; leave it out")
    if name and values:
        raise InputError(f"{where}: values: has a distribution as well; give one of both")
    if not isinstance(values, list) or not all(isinstance(one, bool | int | float | str) for one in values):
        raise InputError(f"{where}: values = {values!r}: must be a list of numbers or texts")
    if not isinstance(name, str):
        raise InputError(f"{where}: distribution = {name!r}: must be a name of scipy.stats")
    if parameters and not name:
        raise InputError(f"{where}: {next(iter(parameters))}: no such key, or the distribution is missing")
    if name and name != CASE:
        _check_distribution(name, parameters, where)
    elif parameters:
        raise InputError(f"{where}: {next(iter(parameters))}: the number of the case has no parameters")
    return Drawn(
        distribution=name,
        parameters=tuple((key, float(value)) for key, value in parameters.items()),
        values=tuple(values),
        nominal=entry.get("nominal"),
        whole=whole,
    )


def _check_distribution(name: str, parameters: Mapping[str, Any], where: str) -> None:
    known = _names()
    if name not in known:
        raise InputError(
            f"{where}: distribution = {name!r}: scipy.stats has none of that name{suggestion(name, known)}"
        )
    family = getattr(scipy.stats, name)
    allowed = [*(family.shapes.split(", ") if family.shapes else []), "loc"]
    allowed += ["scale"] if "scale" in signature(family.pdf if hasattr(family, "pdf") else family.pmf).parameters or (
        hasattr(family, "pdf")) else []  # fmt: skip
    for key, value in parameters.items():
        if key not in allowed:
            raise InputError(f"{where}: {key}: no parameter of {name}; it has {', '.join(allowed)}")
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{where}: {key} = {value!r}: must be a number")
    try:
        middle = float(family(**parameters).ppf(0.5))
    except TypeError:
        raise InputError(f"{where}: distribution = {name!r}: needs {', '.join(allowed)}") from None
    if not np.isfinite(middle):
        raise InputError(f"{where}: distribution = {name!r}: refuses {dict(parameters)}")


def _names() -> Sequence[str]:
    kinds = (scipy.stats.rv_continuous, scipy.stats.rv_discrete)
    return [name for name in dir(scipy.stats) if isinstance(getattr(scipy.stats, name), kinds)]


def with_unit(value: Value, unit: str) -> Value:
    """Return a value as a file may hold it: a text with the unit where there is one."""
    return f"{value!r} {unit}" if unit and not isinstance(value, str) else value
