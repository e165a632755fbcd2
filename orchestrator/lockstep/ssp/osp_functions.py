"""Read the functions of an OspSystemStructure.xml: linear transformations, sums, and sums of vectors."""

from dataclasses import dataclass
from pathlib import Path

from lockstep.errors import InputError, compact, suggestion
from lockstep.ssp.documents.xml import Element, local_name, unique
from lockstep.system.clock import Time
from lockstep.system.component import Component
from lockstep.system.sums import Sums
from lockstep.system.transformation import Hop


@dataclass(frozen=True, slots=True, kw_only=True)
class OspFunction:
    """A function with one of both: a linear transformation of one signal, or sums."""

    name: str
    hop: Hop | None = None
    sums: Sums | None = None

    def gives(self, signal: str) -> bool:
        """Return whether a signal is an output."""
        return signal in (("out",) if self.sums is None else self.sums.inputs)

    def check_signal(self, signal: str) -> None:
        """Raise InputError for a signal that the function does not have."""
        names = ["in", "out"] if self.sums is None else [*self.sums.inputs, *self._inputs()]
        if signal not in names:
            near = compact(names) + suggestion(signal, names)
            raise InputError(f"function {self.name}: no signal {signal}; it has {near}")

    def group(self, name: str) -> list[str]:
        """Return the signals of a vector, `out` or `in[i]`, or raise InputError."""
        if self.sums is not None and name == "out":
            return list(self.sums.inputs)
        found = [signal for signal in self._inputs() if signal.startswith(f"{name}[")]
        if not found or name == "in":
            groups = ["out", *dict.fromkeys(s.rpartition("[")[0] for s in self._inputs())]
            raise InputError(f"function {self.name}: no signal group {name}; it has {compact(groups)}")
        return found

    def component(self, source: Path, period: Time) -> Component:
        """Return the component that computes the sums of this file with a period [ns]."""
        return Component(name=self.name, source=source, period=period, kind="sampled", sums=self.sums)

    def _inputs(self) -> list[str]:
        return [] if self.sums is None else [name for names in self.sums.inputs.values() for name in names]


def read_functions(elements: list[Element], where: str) -> dict[str, OspFunction]:
    """Return the functions of a file by name, or raise InputError."""
    unique((str(e.get("name")) for e in elements), f"{where}: function ")
    return {str(e.get("name")).replace(".", "/"): _function(e, where) for e in elements}


def _function(element: Element, where: str) -> OspFunction:
    name = str(element.get("name")).replace(".", "/")
    what = f"{where}: function {name}"
    match local_name(element):
        case "LinearTransformation":
            factor, offset = (
                _number(element, key, default, what) for key, default in (("factor", 1.0), ("offset", 0.0))
            )
            return OspFunction(name=name, hop=Hop(factor=factor, offset=offset, convert_units=False))
        case "Sum":
            terms = range(_count(element, "inputCount", what))
            return OspFunction(name=name, sums=Sums(inputs={"out": tuple(f"in[{i}]" for i in terms)}))
        case "VectorSum":
            terms, elements = (range(_count(element, key, what)) for key in ("inputCount", "dimension"))
            inputs = {f"out[{j}]": tuple(f"in[{i}][{j}]" for i in terms) for j in elements}
            return OspFunction(name=name, sums=Sums(inputs=inputs))
        case kind:
            known = "LinearTransformation, Sum or VectorSum"
            raise InputError(f"{what}: {kind} is not supported; use {known}, or put it into an FMU")


def _number(element: Element, key: str, default: float, what: str) -> float:
    text = element.get(key)
    try:
        return default if text is None else float(text)
    except ValueError:
        raise InputError(f"{what}: {key} {text!r} must be a number") from None


def _count(element: Element, key: str, what: str) -> int:
    text = str(element.get(key, "")).strip()
    if not (text.isascii() and text.isdigit() and 0 < int(text) <= 10_000):
        raise InputError(f"{what}: {key} {text!r} must be a whole number from 1 to 10000")
    return int(text)
