"""Read from the XML what FMPy 0.3.32 reads wrongly or not at all, and correct its model description.

- relativeQuantity of a variable is always None: FMPy looks for an attribute among the children.
- min, max and quantity of unsigned integers of FMI 3.0 are left out, and all Start elements of a String array but the
  first.
- nominal of a type is not inherited by its variables (nor min and max: see `bound_text` in `model_description`).
- FMI 1.0: capabilities, direct dependencies and negated aliases are not read.
- Lists of dependencies with two blanks, or on several lines, end in an exception; parameters of FMI 2.0 without a
  variability too, whether FMPy is to validate the description or not.
"""

from __future__ import annotations

import io
import os
import re
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from fmpy.model_description import Unknown, ValidationError, read_model_description
from lxml import etree  # type: ignore[import-untyped]

_NAME = "modelDescription.xml"
_LISTS = ("dependencies", "dependenciesKind")
_KINDS = {"dependent", "constant", "fixed", "tunable", "discrete"}
_LONG = 50_000  # characters of dependencies
_TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")  # elements inside a variable of FMI 1.0 and 2.0
_PARAMETERS = ("parameter", "calculatedParameter")
_TRUE = ("true", "1")
_PART = r"[A-Za-z_][A-Za-z0-9_]*(?:\[[0-9]+(?:,[0-9]+)*\])?"
_IDENTIFIER = rf"{_PART}(?:\.{_PART})*"
_PLAIN = re.compile(rf"{_IDENTIFIER}|der\({_IDENTIFIER}(?:,[0-9]+)?\)")  # FMI 2.0.4, 2.2.9, without names in quotes


def read_root(source: str | IO[bytes]) -> etree._Element:
    """Return the root of a model description: of an XML file by its path, or of an FMU as a stream.

    Raises
    ------
    Exception
        Of lxml or zipfile, whatever is wrong.
    """
    parser = etree.XMLParser(resolve_entities=False, no_network=True)
    if isinstance(source, str | os.PathLike):
        return etree.parse(source, parser).getroot()
    with zipfile.ZipFile(source) as archive:
        return etree.fromstring(archive.read(_NAME), parser)


def read_with_fmpy(source: str | IO[bytes], *, validate: bool) -> tuple[Any, etree._Element]:
    """Return FMPy's model description, not corrected yet, and the root.

    Raises
    ------
    Exception
        Of FMPy, lxml or zipfile, whatever is wrong.
    """
    root = read_root(source)
    light = without_initial_dependencies(root)
    if light is not None:
        with suppress(Exception):  # raised again for the file itself, whose lines it names
            return read_model_description(light, validate=validate), root
        root = read_root(_again(source))
    return read_model_description(readable(_again(source), root, lenient=not validate), validate=validate), root


def _again(source: str | IO[bytes]) -> str | IO[bytes]:
    if not isinstance(source, str | os.PathLike):
        source.seek(0)
    return source


def readable(source: str | IO[bytes], root: etree._Element, *, lenient: bool) -> str | IO[bytes]:
    """Return the source, or, where FMPy would end in an exception, an FMU that holds a corrected description alone.

    What is valid is corrected always; a `lenient` reader also reads parameters without a variability, as fixed.
    """
    changed = False
    if lenient and root.get("fmiVersion") == "2.0":
        for variable in root.iterfind("ModelVariables/ScalarVariable"):
            if variable.get("variability") is None and variable.get("causality") in _PARAMETERS:
                variable.set("variability", "fixed")
                changed = True
    for unknown in root.iterfind("ModelStructure//*"):
        for name in _LISTS:
            text = unknown.get(name)
            if text is not None and text != " ".join(text.split()):
                unknown.set(name, " ".join(text.split()))
                changed = True
    return _packed(root) if changed else source


def without_initial_dependencies(root: etree._Element) -> IO[bytes] | None:
    """Return an FMU that holds a description of FMI 2.0 alone, without the dependencies of its initial unknowns.

    Nothing uses them, and FMPy takes longer for long ones than for all the rest. None where they are short, or where
    something in them is wrong, which FMPy then refuses. Otherwise they are removed from the root too.
    """
    unknowns = root.findall("ModelStructure/InitialUnknowns/Unknown") if root.get("fmiVersion") == "2.0" else []
    if sum(len(unknown.get("dependencies", "")) for unknown in unknowns) < _LONG:
        return None
    words = {name: {word for text in {unknown.get(name, "") for unknown in unknowns} for word in text.split()}
             for name in _LISTS}  # fmt: skip
    variables = {str(number) for number, _ in enumerate(_elements(root), 1)}
    if not (words["dependencies"] <= variables and words["dependenciesKind"] <= _KINDS):
        return None
    for unknown in unknowns:
        for name in _LISTS:
            unknown.attrib.pop(name, None)
    return _packed(root)


def _packed(root: etree._Element) -> IO[bytes]:
    """Return an FMU that holds a description alone."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as packed:
        packed.writestr(_NAME, etree.tostring(root, encoding="UTF-8", xml_declaration=True))
    archive.seek(0)
    return archive


def correct(model: Any, root: etree._Element) -> None:
    """Correct FMPy's model description in place."""
    by_name = {}
    for element, variable in zip(_elements(root), model.modelVariables, strict=False):  # aliases of FMI 3.0 come last
        by_name[variable.name] = variable
        _correct(variable, _value(element))
    for variable in model.modelVariables:
        if getattr(variable, "alias", None) is not None:
            variable.relativeQuantity, variable.nominal = variable.alias.relativeQuantity, variable.alias.nominal
            variable.min, variable.max = variable.alias.min, variable.alias.max
    if model.fmiVersion == "1.0":
        _correct_version_1(model, root, by_name)


def _correct(variable: Any, given: Mapping[str, str]) -> None:
    own = given.get("relativeQuantity")
    variable.relativeQuantity = None if own is None else own.strip() in _TRUE
    for name in ("min", "max", "quantity"):
        setattr(variable, name, given.get(name))
    if variable.nominal is None and variable.declaredType is not None:
        variable.nominal = variable.declaredType.nominal


def _correct_version_1(model: Any, root: etree._Element, by_name: Mapping[str, Any]) -> None:
    """Read the capabilities and direct dependencies of FMI 1.0."""
    capabilities = root.find("Implementation/*/Capabilities")
    if capabilities is not None and model.coSimulation is not None:
        for name in ("canBeInstantiatedOnlyOncePerProcess", "canHandleVariableCommunicationStepSize"):
            setattr(model.coSimulation, name, capabilities.get(name, "false").strip() in _TRUE)
    for element in _elements(root):
        declared = element.find("DirectDependency")
        if declared is not None and element.get("causality") == "output":
            names = ((name.text or "").strip() for name in declared.iterfind("Name"))
            sources = [by_name[name] for name in names if name in by_name]
            model.outputs.append(Unknown(variable=by_name[element.get("name")], dependencies=sources))


def text_starts(root: etree._Element) -> dict[str, list[str]]:
    """Return all start values of the Strings of FMI 3.0 that have several, by variable."""
    found = {}
    for element in root.iterfind("ModelVariables/String"):
        starts = [start.get("value", "") for start in element.iterfind("Start")]
        if len(starts) > 1:
            for named in (element, *element.iterfind("Alias")):
                found[named.get("name", "")] = starts
    return found


def negated_aliases(root: etree._Element) -> dict[str, str]:
    """Return the variables of FMI 1.0 whose value is that of another one with the other sign, and the other one."""
    elements = [element for element in _elements(root) if root.get("fmiVersion") == "1.0"]
    bases = {_identity(element): element.get("name") for element in elements if element.get("alias") != "negatedAlias"}
    return {
        element.get("name"): bases.get(_identity(element), "the variable that it is an alias of")
        for element in elements
        if element.get("alias") == "negatedAlias"
    }


def _identity(element: etree._Element) -> tuple[str, str | None]:
    """Return type and value reference, which aliases share."""
    return next((child.tag for child in element if child.tag in _TYPES), ""), element.get("valueReference")


def _elements(root: etree._Element) -> Iterator[etree._Element]:
    """Yield the variables that FMPy reads, in its order."""
    return (element for element in root.find("ModelVariables") if element.get("name") is not None)


def _value(element: etree._Element) -> Mapping[str, str]:
    """Return the attributes of a variable's type element: with FMI 3.0 that is the variable."""
    if element.tag != "ScalarVariable":
        return dict(element.attrib)
    return next((dict(child.attrib) for child in element if child.tag in _TYPES), {})


def validation_problems(path: Path) -> list[str]:
    """Return the problems that FMPy's own validation finds in an FMU; nothing for a good one.

    Names that are plain are not parsed by FMPy: its grammar has them all, and takes a hundredth of a second for each.
    """
    from fmpy.validation import validate_fmu  # here only: it loads a grammar

    if not _plain(path):
        return [str(problem) for problem in validate_fmu(str(path))]
    try:
        read_model_description(str(path), validate=True, validate_model_structure=True)
    except ValidationError as error:
        return [str(problem) for problem in error.problems]
    except Exception as error:
        return [str(error)]
    return []


def _plain(path: Path) -> bool:
    """Return whether an FMU has nothing but plain names of variables, and paths without backslashes."""
    try:
        with path.open("rb") as stream:
            variables = read_root(stream).find("ModelVariables")
        with zipfile.ZipFile(path) as archive:
            paths = [file.orig_filename for file in archive.filelist]
    except Exception:  # whatever is wrong, FMPy says it
        return False
    named = () if variables is None else variables.iterfind(".//*[@name]")
    return not any("\\" in file for file in paths) and all(is_plain(element.get("name", "")) for element in named)


def is_plain(name: str) -> bool:
    """Return whether a name is one that FMI's grammar of structured names has, without quotes."""
    return _PLAIN.fullmatch(name) is not None
