"""Declare a port that shows a parameter: its unit and range are those of the parameter's field."""

from __future__ import annotations

from typing import Any

from ..quantities import quantity
from .table import Causality, Port


def parameter_port(owner: type, field: str, *, name: str, causality: Causality = "parameter", **rest: Any) -> Port:
    """Return a port with unit, minimum and maximum of a field of a parameter class.

    Parameters
    ----------
    owner, field : the parameter, such as `Wheel`, "torque_limit"
    name, causality, rest : of the port; the start value is the number that travels with the component

    FMI limits include their bounds: a parameter that must be > 0 has the minimum 0 here, and 0 is refused at the start.
    """
    known = quantity(owner, field)
    limits = {"minimum": known.range.least, "maximum": known.range.most}
    return Port(name=name, causality=causality, unit=known.unit, **(limits | rest))


def known_error_port(owner: type, field: str, *, name: str, **rest: Any) -> Port:
    """Return a port of an error of either sign, at most as large as the deviation of what is drawn may be."""
    most = quantity(owner, field).range.most
    assert most is not None
    return parameter_port(owner, field, name=name, minimum=-most, **rest)
