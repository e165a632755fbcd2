"""Arrays of FMUs whose files list p[10] before p[2]: values given as a list, and what is recorded, are in order."""

import random
import shutil

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fmus.c_fmu import compile_library, pack_fmu
from lockstep import Component, Connection, System, load_system, read_signals, simulate, write_ssd
from lockstep.__main__ import main
from lockstep.adapter.component import replace_component
from lockstep.adapter.read import read_adapter
from lockstep.faults.read import read_scenario

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the FMU is compiled with gcc")
STEP = 10_000_000  # [ns]
VECTOR = [f"p[{k}]" for k in range(1, 13)]
MATRIX = [f"a[{row},{column}]" for row in (1, 2) for column in range(1, 12)]
INPUTS = [f"u[{k}]" for k in range(1, 13)]
OUTPUTS = {name: name.replace("p", "y").replace("a", "b").replace("u", "v") for name in VECTOR + MATRIX + INPUTS}
VALUES = np.arange(1.0, 13.0)
GRID = np.arange(22.0).reshape(2, 11)
CODE = """
#include <stdlib.h>
#include "fmi2Functions.h"
enum { N = 64 };
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)type, (void)guid, (void)resources, (void)callbacks, (void)visible, (void)logging;
    return calloc(N, sizeof(double));
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean keep)
{
    (void)c, (void)t, (void)h, (void)keep;
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[])
{
    for (size_t k = 0; k < n; k++) v[k] = ((double *)c)[r[k] % N];
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[])
{
    for (size_t k = 0; k < n; k++) ((double *)c)[r[k] % N] = v[k];
    return fmi2OK;
}
"""


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    """Return an FMU whose outputs y, b and v are its parameters p and a and its input u, listed in no order."""
    folder = tmp_path_factory.mktemp("arrays")
    (folder / "arrays.c").write_text(CODE)
    compile_library(folder / "arrays.so", [folder / "arrays.c"])
    rows = []
    for number, (name, output) in enumerate(OUTPUTS.items()):
        kind = 'causality="input"' if name in INPUTS else 'causality="parameter" variability="tunable"'
        rows.append(
            f'<ScalarVariable name="{name}" valueReference="{number}" {kind}><Real start="0"/></ScalarVariable>'
        )
        reference = number + 64  # of the same place
        rows.append(f'<ScalarVariable name="{output}" valueReference="{reference}" causality="output"><Real/>'
                    "</ScalarVariable>")  # fmt: skip
    random.Random(4).shuffle(rows)
    unknowns = "".join(f'<Unknown index="{k}"/>' for k, row in enumerate(rows, 1) if "output" in row)
    description = (
        '<fmiModelDescription fmiVersion="2.0" modelName="arrays" guid="g" variableNamingConvention="structured">'
        f'<CoSimulation modelIdentifier="arrays"/><ModelVariables>{"".join(rows)}</ModelVariables><ModelStructure>'
        f"<Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure>"
        "</fmiModelDescription>"
    )
    return pack_fmu(folder / "arrays.fmu", description, folder / "arrays.so")


@pytest.fixture
def system(fmu):
    """Return two of them, of which the first gives y to the second's u."""
    first, second = (
        Component(name=name, source=fmu, period=STEP, kind="sampled", isolated=False) for name in ("c", "d")
    )
    wires = tuple(
        Connection(from_component="c", output=OUTPUTS[p], to_component="d", input=u)
        for p, u in zip(VECTOR, INPUTS, strict=True)
    )
    return System(name="arrays", tick=STEP, stop_time=5 * STEP, components=(first, second), connections=wires)


def test_lists_of_the_api_and_recorded_arrays(system, tmp_path):
    simulate(system, tmp_path / "out", overrides={"c.p": VALUES, "c.a": GRID, "c.u": list(-VALUES), "d.a": [7.0]})
    signals = read_signals(tmp_path / "out")

    assert_array_equal(signals["c.y"][-1], VALUES)
    assert_array_equal(signals["c.b"][-1], GRID.ravel())
    assert_array_equal(signals["c.v"][-1], -VALUES)
    assert_array_equal(signals["d.v"][-1], VALUES)
    assert_array_equal(signals["d.b"][-1], 7.0)
    assert [name for name in signals.columns if name.startswith("c.y")] == [f"c.{OUTPUTS[name]}" for name in VECTOR]


def test_lists_of_the_command_line_and_values_of_a_system_file(system, tmp_path):
    first, second = system.components
    values = {f"a[{row},{column}]": GRID[row - 1, column - 1] for row in (1, 2) for column in range(1, 12)}
    parts = (Component(**{**_fields(first), "parameters": values}), second)
    path = tmp_path / "arrays.ssd"
    write_ssd(System(**{**_fields(system), "components": parts}), path)
    texts = [str(value) for value in VALUES]
    rows = ["[" + ", ".join(map(str, row)) + "]" for row in GRID.tolist()]
    settings = (f"c.p={','.join(texts)}", f"c.u=[{','.join(texts)}]", f"d.a=[{', '.join(rows)}]")

    assert main(["run", str(path), "--out", str(tmp_path / "out"), *(f"--set={text}" for text in settings)]) == 0
    signals = read_signals(tmp_path / "out")
    assert load_system(path).component("c").parameters == values
    assert_array_equal(signals["c.y"][-1], VALUES)
    assert_array_equal(signals["c.v"][-1], VALUES)
    assert_array_equal(signals["c.b"][-1], GRID.ravel())
    assert_array_equal(signals["d.b"][-1], GRID.ravel())


def _fields(value):
    return {name: getattr(value, name) for name in value.__dataclass_fields__}


def test_lists_of_a_fault_and_arrays_of_an_adapter(system, fmu, tmp_path):
    faults, adapter = tmp_path / "f.toml", tmp_path / "a.toml"
    faults.write_text(
        f'[[fault]]\nconnection = "d.u"\nkind = "stuck"\nvalue = {(10.0 * VALUES).tolist()}\nfrom = 0.02\nto = 1.0\n'
    )
    adapter.write_text(
        'ignore = ["b*"]\n[[input]]\nport = "u"\nvariable = "u[*]"\n[[output]]\nport = "v"\nvariable = "v[*]"\n'
        '[[output]]\nport = "y"\nvariable = "y[*]"\nscale = 0.5\n'
    )
    replaced = replace_component(system, "c", fmu, read_adapter(adapter))
    simulate(
        replaced, tmp_path / "out", overrides={"c.p": VALUES, "c.u": -VALUES}, record=["all"],
        faults=[read_scenario(faults)],
    )  # fmt: skip
    signals = read_signals(tmp_path / "out")

    assert_array_equal(signals["c.y"][-1], 2.0 * VALUES)
    assert_array_equal(signals["c.v"][-1], -VALUES)
    assert_array_equal(signals["d.v"][1], 2.0 * VALUES)
    assert_array_equal(signals["d.v"][-1], 10.0 * VALUES)


def test_arrays_of_fmi_3(reference_fmu, tmp_path):
    part = Component(name="f", source=reference_fmu("feedthrough", "3.0"), period=STEP, kind="sampled", isolated=False)
    given = {"vector_in": [1.0, 2.0, 3.0], "matrix_in": GRID[:, :3], "whole_in": "5,6", "flags_in": "[true, false]"}
    zero = (
        "Float64",
        "Float32",
        "Int8",
        "Int16",
        "Int32",
        "Int64",
        "UInt8",
        "UInt16",
        "UInt32",
        "UInt64",
        "Enumeration",
    )
    given |= {f"{kind}_in": 0 for kind in zero} | {"Boolean_in": False, "String_in": "a", "narrow_in": 1.0}
    given |= {"words_in": ["left", "right"]}
    one = System(name="s", tick=STEP, stop_time=2 * STEP, components=(part,))
    simulate(one, tmp_path / "out", overrides={f"f.{name}": value for name, value in given.items()})
    signals = read_signals(tmp_path / "out")

    assert_array_equal(signals["f.vector_out"][-1], [1.0, 2.0, 3.0])
    assert_array_equal(signals["f.matrix_out"][-1], GRID[:, :3].ravel())
    assert_array_equal(signals["f.whole_out"][-1], [5, 6])
    assert_array_equal(signals["f.flags_out"][-1], [True, False])
    assert [signals[f"f.words_out[{k}]"][-1] for k in (1, 2)] == ["left", "right"]
