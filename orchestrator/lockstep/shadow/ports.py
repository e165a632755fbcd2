"""What a component shows that has a shadow, and where each of its values comes from or goes to.

It shows the variables of the original under their names, of which those handed over are what acts, and besides

- `original.X` and `residual.X`: what the original gives for a handed-over X, and the shadow's less that;
- `shadow.X`: every output and parameter of the shadow, and inputs that the original does not have.

Inputs and parameters that both have are given to both; `shadow.X` gives a parameter to the shadow alone.

An estimator that rides along and takes its own output for what acted is wrong in that. So an input `applied.X` of the
shadow gets the X that acted in its last step, the mean of a Real, and a Boolean input `applied.valid` is true then.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from lockstep.errors import InputError
from lockstep.fmi.model_description import Description, Variable
from lockstep.system.units import checked_conversion

ORIGINAL, SHADOW, RESIDUAL, APPLIED = "original.", "shadow.", "residual.", "applied."

Key = tuple[str, int]  # type and value reference


@dataclass(frozen=True, slots=True, kw_only=True)
class Match:
    """A variable of the shadow and its counterpart; the receiver of a value takes gain * value + bias."""

    shown: Variable  # of the component
    theirs: Variable  # of the shadow
    gain: float = 1.0
    bias: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Joined:
    """The variables shown, and how they lie on the two FMUs."""

    name: str  # of the shadow, in messages
    variables: Mapping[str, Variable]
    given: tuple[Match, ...]  # inputs and parameters of both; then those of the shadow alone
    handed: tuple[Match, ...]  # outputs that are handed over; the conversion is from theirs to shown
    seen: tuple[Match, ...]  # `shadow.X` of all outputs of the shadow
    applied: tuple[Match, ...]  # shown: the output that acts; theirs: the input that is told of it
    told: Variable | None  # of the shadow: true, for it is told


def join(name: str, outputs: Sequence[str], original: Description, shadow: Description) -> Joined:
    """Match two descriptions by names, types and units, or raise InputError."""
    ours, theirs = original.variables, shadow.variables
    handed = [_handed(name, ours[output], theirs, shadow) for output in outputs]
    applied = [match for output in handed if (match := _applied(name, output.shown, theirs)) is not None]
    flag = theirs.get(f"{APPLIED}valid")
    told = flag if applied and flag is not None and (flag.scalar, flag.causality) == ("Boolean", "input") else None
    fed = {match.theirs.name for match in applied} | ({told.name} if told else set())
    given = [
        _given(name, variable, theirs[variable.name])
        for variable in ours.values()
        if variable.name not in fed and _same(variable, theirs.get(variable.name))
    ]
    both = {match.shown.name for match in given if match.shown.causality == "input"}
    reference = 1 + max((variable.reference for variable in ours.values()), default=0)
    variables = dict(ours)

    def show(prefix: str, variable: Variable) -> Variable:
        nonlocal reference
        shown = replace(variable, name=f"{prefix}{variable.name}", reference=reference)
        if shown.name in variables:
            raise InputError(f"{name}: {shown.name} is the name of another variable already; it cannot be shown")
        variables[shown.name] = shown
        reference += 1
        return shown

    for match in handed:
        show(ORIGINAL, match.shown)
        if match.shown.scalar == "Real":
            show(RESIDUAL, replace(match.shown, description="shadow less original", minimum=None, maximum=None))
    seen, alone = [], []
    for variable in theirs.values():
        if variable.causality == "output" and variable.scalar is not None:
            seen.append(_seen(show, variable, handed))
        elif variable.causality == "parameter" or (
            variable.causality == "input" and variable.name not in both and variable.name not in fed
        ):
            alone.append(Match(shown=show(SHADOW, variable), theirs=variable))
    return Joined(
        name=name,
        variables=variables,
        given=(*given, *alone),
        handed=tuple(handed),
        seen=tuple(seen),
        applied=tuple(applied),
        told=told,
    )


def _handed(name: str, ours: Variable, theirs: Mapping[str, Variable], shadow: Description) -> Match:
    other = theirs.get(ours.name)
    if other is None or other.causality != "output":
        raise InputError(
            f"{shadow.lacks(name, ours.name, 'output')}; it has to give what it takes over: "
            "use an adapter, or [substitutes] in it"
        )
    what = f"{name}.{ours.name}"
    if other.scalar != ours.scalar:
        raise InputError(f"{what}: is {other.type}, and the original's is {ours.type}; types must be equal")
    gain, bias = checked_conversion(other.unit, ours.unit, ours.relative, what) if ours.scalar == "Real" else (1.0, 0.0)
    return Match(shown=ours, theirs=other, gain=gain, bias=bias)


def _applied(name: str, ours: Variable, theirs: Mapping[str, Variable]) -> Match | None:
    told = theirs.get(f"{APPLIED}{ours.name}")
    if told is None or told.causality != "input" or told.scalar != ours.scalar:
        return None
    what = f"{name}.{told.name}"
    gain, bias = checked_conversion(ours.unit, told.unit, ours.relative, what) if ours.scalar == "Real" else (1.0, 0.0)
    return Match(shown=ours, theirs=told, gain=gain, bias=bias)


def _same(ours: Variable, theirs: Variable | None) -> bool:
    """Tell whether the shadow gets what this variable of the original gets."""
    if theirs is None or ours.causality not in ("input", "parameter"):
        return False
    if (ours.scalar, ours.causality) != (theirs.scalar, theirs.causality):
        return False
    # parameters of two makers may have one name and two meanings: those of one unit are taken to be the same
    return ours.causality == "input" or ours.unit == theirs.unit


def _given(name: str, ours: Variable, theirs: Variable) -> Match:
    if ours.scalar != "Real":
        return Match(shown=ours, theirs=theirs)
    gain, bias = checked_conversion(ours.unit, theirs.unit, ours.relative, f"{name}.{ours.name}")
    return Match(shown=ours, theirs=theirs, gain=gain, bias=bias)


def _seen(show: Callable[[str, Variable], Variable], variable: Variable, handed: Sequence[Match]) -> Match:
    """Show an output of the shadow, in the original's unit if it is one that is handed over."""
    match = next((match for match in handed if match.theirs.name == variable.name), None)
    if match is None:
        return Match(shown=show(SHADOW, variable), theirs=variable)
    shown = show(SHADOW, replace(variable, unit=match.shown.unit))
    return Match(shown=shown, theirs=variable, gain=match.gain, bias=match.bias)
