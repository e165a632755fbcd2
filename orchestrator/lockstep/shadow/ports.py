"""Match the variables of a component with those of its shadow, and list what the two show together.

The component keeps the variables of the original. An output that others read is the one that acts: of the original, or
of the shadow after the switchover. In addition there are

- `original.X` and `residual.X`: the original's value of such an output, and the shadow's minus it;
- `shadow.X`: every output and parameter of the shadow, and inputs that the original does not have.

Inputs and parameters that both have are set on both; `shadow.X` sets a parameter of the shadow alone.

The shadow's own output does not act before the switchover, which its estimator has to know. So an input `applied.X` of
the shadow gets the X that acted during its last step, for a Real the mean, and a Boolean input `applied.valid` is true.
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
    """Pair a variable of the shadow with one of the component; the receiver gets gain * value + bias."""

    shown: Variable  # of the component
    shadow: Variable
    gain: float = 1.0
    bias: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Joined:
    """Hold the variables shown, and their counterparts in the two FMUs."""

    name: str  # of the shadow, in messages
    variables: Mapping[str, Variable]
    given: tuple[Match, ...]  # inputs and parameters of both; then those of the shadow alone
    acting: tuple[Match, ...]  # outputs that others read; converted from the shadow's to the shown
    seen: tuple[Match, ...]  # `shadow.X` of all outputs of the shadow
    applied: tuple[Match, ...]  # shown: the output that acts; shadow: the input that gets it
    applied_valid: Variable | None  # of the shadow: true if there is an `applied`


def join(name: str, outputs: Sequence[str], original: Description, shadow: Description) -> Joined:
    """Match two descriptions by names, types and units, or raise InputError."""
    own, others = original.variables, shadow.variables
    acting = [_acting(name, own[output], shadow) for output in outputs]
    applied = [match for output in acting if (match := _applied(name, output.shown, others)) is not None]
    flag = others.get(f"{APPLIED}valid")
    valid = flag if applied and flag is not None and (flag.scalar, flag.causality) == ("Boolean", "input") else None
    fed = {match.shadow.name for match in applied} | ({valid.name} if valid else set())
    given = [
        _given(name, variable, others[variable.name])
        for variable in own.values()
        if variable.name not in fed and _is_shared(variable, others.get(variable.name))
    ]
    both = {match.shown.name for match in given if match.shown.causality == "input"}
    reference = 1 + max((variable.reference for variable in own.values()), default=0)
    variables = dict(own)

    def show(prefix: str, variable: Variable) -> Variable:
        nonlocal reference
        shown = replace(variable, name=f"{prefix}{variable.name}", reference=reference)
        if shown.name in variables:
            raise InputError(f"{name}: {shown.name} is the name of another variable already; it cannot be shown")
        variables[shown.name] = shown
        reference += 1
        return shown

    for match in acting:
        show(ORIGINAL, match.shown)
        if match.shown.scalar == "Real":
            change = replace(
                match.shown, description="shadow minus original", minimum=None, maximum=None, relative=True
            )
            show(RESIDUAL, change)
    seen, alone = [], []
    for variable in others.values():
        if variable.causality == "output" and variable.scalar is not None:
            seen.append(_seen(show, variable, acting))
        elif variable.causality == "parameter" or (
            variable.causality == "input" and variable.name not in both and variable.name not in fed
        ):
            alone.append(Match(shown=show(SHADOW, variable), shadow=variable))
    return Joined(
        name=name,
        variables=variables,
        given=(*given, *alone),
        acting=tuple(acting),
        seen=tuple(seen),
        applied=tuple(applied),
        applied_valid=valid,
    )


def _acting(name: str, original: Variable, description: Description) -> Match:
    shadow = description.variables.get(original.name)
    if shadow is None or shadow.causality != "output":
        raise InputError(
            f"{description.lacks(name, original.name, 'output')}; it needs every output that it may replace: "
            "use an adapter, or [substitutes] in it"
        )
    what = f"{name}.{original.name}"
    if shadow.scalar != original.scalar:
        raise InputError(f"{what}: is {shadow.type}, and the original's is {original.type}; types must be equal")
    return _converted(shown=original, shadow=shadow, source=shadow, target=original, what=what)


def _applied(name: str, original: Variable, others: Mapping[str, Variable]) -> Match | None:
    shadow = others.get(f"{APPLIED}{original.name}")
    if shadow is None or shadow.causality != "input" or shadow.scalar != original.scalar:
        return None
    return _given(name, original, shadow)


def _is_shared(original: Variable, shadow: Variable | None) -> bool:
    """Return whether a value for this variable of the original is set on the shadow too."""
    if shadow is None or original.causality not in ("input", "parameter"):
        return False
    if (original.scalar, original.causality) != (shadow.scalar, shadow.causality):
        return False
    # parameters of two makers may have one name and two meanings: those of one unit are taken to be the same
    return original.causality == "input" or original.unit == shadow.unit


def _given(name: str, original: Variable, shadow: Variable) -> Match:
    return _converted(shown=original, shadow=shadow, source=original, target=shadow, what=f"{name}.{shadow.name}")


def _converted(*, shown: Variable, shadow: Variable, source: Variable, target: Variable, what: str) -> Match:
    if shown.scalar != "Real":
        return Match(shown=shown, shadow=shadow)
    gain, bias = checked_conversion(source.unit, target.unit, source.relative and target.relative, what)
    return Match(shown=shown, shadow=shadow, gain=gain, bias=bias)


def _seen(show: Callable[[str, Variable], Variable], variable: Variable, acting: Sequence[Match]) -> Match:
    """Show an output of the shadow, in the original's unit if it may act."""
    match = next((match for match in acting if match.shadow.name == variable.name), None)
    if match is None:
        return Match(shown=show(SHADOW, variable), shadow=variable)
    shown = show(SHADOW, replace(variable, unit=match.shown.unit))
    return Match(shown=shown, shadow=variable, gain=match.gain, bias=match.bias)
