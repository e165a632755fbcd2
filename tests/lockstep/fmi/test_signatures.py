"""The C signatures of the driver against the headers of the standard."""

import re
from ctypes import c_bool, c_char, c_double, c_int, c_size_t, c_void_p
from pathlib import Path

import fmpy
import pytest

from lockstep.fmi.signatures import ENDINGS, SIGNATURES

HEADERS = Path(fmpy.__file__).parent / "c-code"
TYPES = {  # of arguments that are no pointers and no arrays
    "Component": c_void_p, "Instance": c_void_p, "FMUstate": c_void_p, "FMUState": c_void_p, "Real": c_double,
    "Float64": c_double, "StatusKind": c_int, "size_t": c_size_t,
}  # fmt: skip
BOOLEANS = {"fmi1": c_char, "fmi2": c_int, "fmi3": c_bool}
FILES = {"fmi1": "fmi1Functions.h", "fmi2": "fmi2FunctionTypes.h", "fmi3": "fmi3FunctionTypes.h"}


def declared(prefix):
    """Return the argument types of every function that a header declares, by name without prefix."""
    text = re.sub(r"/\*.*?\*/|//[^\n]*", "", (HEADERS / FILES[prefix]).read_text("utf-8"), flags=re.S)
    functions = re.findall(rf"typedef\s+\S+\s+{prefix}(\w+)TYPE\s*\((.*?)\)\s*;", text, flags=re.S)
    return {name: tuple(argument_type(part, prefix) for part in parts.split(",") if part) for name, parts in functions}


def argument_type(text, prefix):
    """Return the type of one argument as ctypes has it: `const fmi2Real value[]` is a pointer."""
    kind = re.sub(r"\bconst\b", "", text).split()[0].removeprefix(prefix)
    if "*" in text or "[" in text:
        return c_void_p
    return BOOLEANS[prefix] if kind == "Boolean" else TYPES.get(kind, kind)


@pytest.mark.parametrize("prefix", SIGNATURES)
def test_signatures_are_those_of_the_header(prefix):
    header = declared("fmi1" if prefix == "fmi" else prefix)

    assert {name: header[name] for name in SIGNATURES[prefix]} == {
        name: (c_void_p, *kinds) for name, kinds in SIGNATURES[prefix].items()
    }


def test_endings_are_functions_with_signatures():
    assert all(set(ENDINGS[prefix]) <= SIGNATURES[prefix].keys() for prefix in SIGNATURES)
