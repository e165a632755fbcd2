"""The keys of a spacecraft's file, from the classes that they fill: unit, default, range, comment."""

from __future__ import annotations

import ast
import inspect
import io
import math
import textwrap
import tokenize
from collections.abc import Iterator, Sequence
from dataclasses import MISSING, dataclass, fields
from typing import Any, Literal, get_args, get_origin, get_type_hints

from ..controller_weights import Weights
from ..parameters import Aperture, Harmonic, Modes, Plate, Rates, SensorErrors, SensorNoise, Slew, SpeedSelection, Wheel
from ..quantities import Range
from .appendage import Appendage
from .configuration import RELEASE, Release
from .placement import Bus, Site
from .units import units_for


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyRow:
    """One key of a table."""

    key: str
    unit: str  # in which a bare number is, and others that a text may have
    default: str
    range: str
    meaning: str


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyTable:
    """One table of a file, and its keys."""

    title: str  # as it stands in a file
    meaning: str
    rows: Sequence[KeyRow]


# keys of a list of devices: key, default, meaning
_DEVICES = (
    ("at", "", "name of a site"),
    ("axes", "", 'list of "+x" to "-z", or of directions of any length in body axes: one device along each'),
    ("kind", "[wheel]", "wheels only: NAME of a table [wheel_kinds.NAME], which has the keys of [wheel]"),
    ("noise", "[noise] gyro", "gyros only: standard deviation of a sample, rad/s, deg/s, rpm, deg/h"),
    (
        "mounting_error",
        "[0, 0, 0]",
        "gyros only: rotation vector off the axes, rad, deg, arcsec; unknown to the filters",
    ),
)
# title, class, fields that a file does not give, keys that it has beside the fields: key, default, meaning
_TABLES: tuple[tuple[str, type, tuple[str, ...], tuple[tuple[str, str, str], ...]], ...] = (
    ("[sites] NAME = { ... }", Site, ("name",), ()),
    ("[bus]", Bus, (), ()),
    ("[wheel]", Wheel, ("harmonics",), (("factor", "1.0", "multiplies inertia, torques, imbalance, broadband jitter"),
     ("harmonics", "[]", "list of the next table"))),
    ("harmonics = [{ ... }] of a wheel", Harmonic, (), ()),
    ("[aperture]", Aperture, (), ()),
    ("[plate]", Plate, (), ()),
    ("[modes]", Modes, (), ()),
    ("[[appendages]]", Appendage, ("structure",), (("file", "", "modal file, relative to the folder of this file"),
     ("damping_ratio", "", "of every mode; default: those of the modal file"))),
    ("[noise]", SensorNoise, (), ()),
    ("[sensor_errors]", SensorErrors, (), ()),
    ("[rates]", Rates, (), ()),
    ("[slew]", Slew, (), ()),
    ("[speeds]", SpeedSelection, (), ()),
    ("[controller], [controller.robust], [controller.published]", Weights, (), ()),
    (f"[{RELEASE}]", Release, (), ()),
)  # fmt: skip


def schema() -> Iterator[KeyTable]:
    """Yield the tables of a spacecraft's file in their usual order."""
    top = [
        ("name", "", "small letters, digits and _: FMUs are built to fmus/NAME"),
        ("layout", "the number of wheels", "shown in the documentation of the FMUs"),
        ("wheels, gyros, accelerometers", "", "lists of the next table"),
    ]
    yield KeyTable(title="at the top", meaning="", rows=[_plain(*one) for one in top])
    yield KeyTable(
        title='wheels = [{ at = "bus", axes = ["+x"] }]', meaning="", rows=[_plain(*one) for one in _DEVICES]
    )
    for title, owner, without, also in _TABLES:
        rows = [_row(owner, item, comment) for item, comment in _commented(owner) if item.name not in without]
        meaning = (owner.__doc__ or "").partition("\n")[0]
        yield KeyTable(title=title, meaning=meaning, rows=[*rows, *(_plain(*one) for one in also)])


def schema_markdown() -> str:
    """Return the tables as a page of Markdown."""
    lines = [
        "# Keys of a spacecraft's file",
        "",
        "All tables and keys of a spacecraft's file; [how to use it](your_own_spacecraft.md)."
        " `flexsat spacecraft --schema` writes this page.",
        'A number is in the first unit; a text may have any of the units, such as "0.2 arcsec". P and C in remarks are'
        " sources:",
        "the paper and its authors' release. A key without a default must be given where its table is.",
    ]
    for table in schema():
        lines += ["", f"## `{table.title}`", "", *([table.meaning, ""] if table.meaning else [])]
        lines += ["| key | unit | default | range | remark |", "|---|---|---|---|---|"]
        lines += [f"| `{r.key}` | {r.unit} | {r.default} | {r.range} | {r.meaning} |" for r in table.rows]
    return "\n".join(lines) + "\n"


def _plain(key: str, default: str, meaning: str) -> KeyRow:
    return KeyRow(key=key, unit="", default=default, range="", meaning=meaning)


def _row(owner: type, item: Any, comment: str) -> KeyRow:
    hint = get_type_hints(owner, include_extras=True)[item.name]
    unit, limits = "", Range()
    options = [one for one in get_args(hint) if one is not type(None)]
    if type(None) in get_args(hint) and len(options) == 1:
        hint = options[0]  # it may be left out
    if hasattr(hint, "__metadata__"):
        given, *rest = hint.__metadata__
        unit = "" if given == "1" else ", ".join(units_for(given))
        limits, hint = rest[0] if rest else limits, hint.__origin__
    known = limits if limits != Range() else None
    text = "" if known is None else str(known)
    if owner is Weights:
        text = ">= 0"
    if get_origin(hint) is Literal:
        text = " or ".join(get_args(hint))
    elif get_origin(hint) is tuple and hint != tuple[str, ...]:
        sizes = get_args(hint)
        many = "numbers" if Ellipsis in sizes else f"{len(sizes)} numbers"
        text = f"{many}{'' if known is None else f', each {known}'}"
    if item.default is MISSING and item.default_factory is MISSING:
        default = ""
    else:
        default = _shown(item.default if item.default is not MISSING else item.default_factory())
    return KeyRow(key=item.name, unit=unit, default=default, range=text, meaning=comment.replace("|", "or"))


def _shown(value: Any) -> str:
    if value is None or value == ():
        return "none"
    if isinstance(value, tuple):
        return f"[{', '.join(map(_shown, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and math.isfinite(value):
        return f"{value:.7g}"
    return "none" if value == "" else str(value)


def _commented(owner: type) -> Iterator[tuple[Any, str]]:
    """Yield the fields of a class, each with the comments of the lines that declare it."""
    source = textwrap.dedent(inspect.getsource(owner))
    comments: dict[int, str] = {}
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            comments[token.start[0]] = token.string.lstrip("# ").strip()
    (body,) = ast.parse(source).body
    assert isinstance(body, ast.ClassDef)
    spans = {
        node.target.id: (node.lineno, node.end_lineno or node.lineno)
        for node in body.body
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
    }
    for item in fields(owner):
        first, last = spans[item.name]
        yield item, "; ".join(comments[line] for line in range(first, last + 1) if line in comments)
