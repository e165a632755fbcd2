"""The text parts of a component's documentation; its tables are made from the ports."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Equation:
    """One equation.

    Attributes
    ----------
    formula : HTML, with `<i>`, `<b>`, `<sub>` and `<sup>` alone
    meaning : plain text: what it describes, and the meaning of its symbols
    source : where it comes from; P is the paper
    """

    formula: str
    meaning: str
    source: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ComponentText:
    """The text on one component that its ports do not contain. Every string is plain text but the formulas.

    Attributes
    ----------
    summary : one sentence
    models : what it models, and what it leaves out
    equations : in the order of evaluation
    timing : when inputs are read, when outputs are true, which steps are accepted
    state : what getFMUstate saves, and what is random
    """

    title: str
    summary: str
    models: tuple[str, ...]
    equations: tuple[Equation, ...]
    timing: tuple[str, ...]
    state: tuple[str, ...]


PAPER = (
    "P: P. Cachim, W. Kraus, Z. Manchester, P. Lourenço, R. Ventura, Optimal Attitude Control of Large Flexible"
    " Space Structures with Distributed Momentum Actuators, IEEE Aerospace Conference 2025, arXiv 2410.07376."
)
FRAMES = (
    "Body axes: origin at the centre of mass at rest, x and y in the plane of the structure, z normal to it; without a"
    " mass of the bus that is the centre of the aperture. Inertial axes: where the"
    " body axes are at attitude zero.",
    "Attitudes are “body from inertial”: they take components in inertial axes to components in body axes."
    " Quaternions are scalar-last. Modified Rodrigues parameters (MRP) are the rotation axis times the tangent of a"
    " quarter of the angle, short rotation.",
    "Everything is SI with radians. Display units in the model description are for display in tools; values are always"
    " set and read in the unit itself.",
)
