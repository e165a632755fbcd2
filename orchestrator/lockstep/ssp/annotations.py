"""Read annotations of SSP elements: those of type `lockstep`, and the steps that OSP's tools and OMSimulator write."""

from collections.abc import Sequence
from dataclasses import dataclass

from lockstep.errors import InputError
from lockstep.ssp.documents.xml import ANNOTATION, LOCKSTEP, NS, Element
from lockstep.system.clock import Time, nanoseconds, positive_nanoseconds
from lockstep.system.component import Kind

SYSTEM_ATTRIBUTES = ("tick", "recordPeriod", "strictInputs")


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredSteps:
    """Hold what a file declares of a component's steps; None: nothing. Times in ns."""

    period: Time | None = None
    offset: Time = 0
    kind: Kind | None = None
    isolated: bool | None = None
    native: bool = False  # the native FMU beside the one that is named
    tolerance: float | None = None  # relative, of the FMU's integration
    annotated: bool = False  # in an annotation of type `lockstep`
    hint: Time | None = None  # StepSizeHint of the Open Simulation Platform


def annotation(element: Element, tag: str, name: str, attributes: Sequence[str]) -> Element | None:
    """Return the `lockstep` annotation of an element, or None; raise InputError if it is malformed."""
    found = element.findall(f"ssd:Annotations/ssc:Annotation[@type='{ANNOTATION}']/*", NS)
    if not found:
        return None
    if len(found) > 1 or found[0].tag != f"{{{LOCKSTEP}}}{tag}":
        raise InputError(f"{name}: the {ANNOTATION} annotation must hold one {tag} element in namespace {LOCKSTEP}")
    for attribute in found[0].attrib:
        if attribute not in attributes:
            raise InputError(f"{name}: annotation {attribute}: no such attribute; there are {', '.join(attributes)}")
    return found[0]


def declared_steps(element: Element, name: str) -> DeclaredSteps:
    """Read the steps that the annotations of a component declare, or raise InputError."""
    hints = element.findall("ssd:Annotations/ssc:Annotation/osp:StepSizeHint", NS)
    hint = positive_nanoseconds(hints[0].get("value", ""), f"{name}: StepSizeHint") if hints else None
    own = annotation(element, "Component", name, ("period", "offset", "kind", "isolated", "native", "tolerance"))
    if own is None:
        return DeclaredSteps(hint=hint)
    kind = own.get("kind")
    if kind not in (None, "sampled", "continuous"):
        raise InputError(f"{name}: kind {kind!r} must be sampled or continuous")
    return DeclaredSteps(
        period=positive_nanoseconds(own.attrib["period"], f"{name}: period") if "period" in own.attrib else None,
        offset=nanoseconds(own.get("offset", "0"), f"{name}: offset"),
        kind=kind,
        isolated=flag(own, "isolated", name),
        native=bool(flag(own, "native", name)),
        tolerance=_number(own, "tolerance", name),
        annotated=True,
        hint=hint,
    )


def master_step(root: Element) -> Time | None:
    """Return the step size of OMSimulator's or OSP's master in the file [ns], or None."""
    for holder in ("ssd:System", "ssd:DefaultExperiment"):
        for tag, attribute in (("FixedStepMaster", "stepSize"), ("FixedStepAlgorithm", "baseStepSize")):
            for found in root.iterfind(f"{holder}/ssd:Annotations/ssc:Annotation//{{*}}{tag}", NS):
                if found.get(attribute):
                    return positive_nanoseconds(found.get(attribute), f"{tag} {attribute}")
    return None


def connection_delay(element: Element, name: str) -> int | None:
    """Return the declared delay of a connection in ticks, or None; raise InputError if it is malformed."""
    own = annotation(element, "Connection", name, ("delay",))
    text = None if own is None else own.get("delay")
    if text is None:
        return None if own is None else 0
    if not (text.isascii() and text.isdecimal()):
        raise InputError(f"{name}: delay {text!r} must be a whole number of ticks >= 0")
    return int(text)


def _number(element: Element, attribute: str, name: str) -> float | None:
    text = element.get(attribute)
    try:
        return None if text is None else float(text)
    except ValueError:
        raise InputError(f"{name}: {attribute} {text!r} must be a number, for example 1e-6") from None


def flag(element: Element, attribute: str, name: str) -> bool | None:
    """Return whether an annotation's attribute is true; None if it is not given. Raises InputError."""
    text = element.get(attribute)
    if text not in (None, "true", "false", "1", "0"):
        raise InputError(f"{name}: {attribute} {text!r} must be true or false")
    return None if text is None else text in ("true", "1")
