"""Small FMUs of the kind of the Modelica Reference FMUs, compiled: the same models in FMI 1.0, 2.0 and 3.0.

Each model is a table of variables here and a few lines of C next to this file; the model description and the struct
that the C code works on come from the same table.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from xml.sax.saxutils import quoteattr

from fmus.c_fmu import compile_library, pack_fmu, quoted

HERE = Path(__file__).parent
TOKEN = "{5b0b1f7e-3c58-4f5e-9d0b-4f3a7d6e2c10}"
VERSIONS = ("1.0", "2.0", "3.0")
INTEGERS = tuple(f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64))
ITEMS = {"off": 0, "coarse": 3, "fine": 7}
NUMBERS = (2.5, -1.0, 4.0)  # what the resource reader reads
UNITS = {"m": 'm="1"', "m/s": 'm="1" s="-1"', "mm": 'm="1" factor="0.001"'}

_C_TYPES = {"Float32": "float", "Float64": "double", "Boolean": "BOOL", "String": "Text", "Enumeration": "int64_t"}
_C_TYPES |= {kind: f"{kind.lower()}_t" for kind in INTEGERS}
_BOOLEANS = {"1.0": "char", "2.0": "int", "3.0": "bool"}
_OLDER = {"Float64": "Real", "Int32": "Integer"}  # the types of FMI 1.0 and 2.0


@dataclass(frozen=True)
class Variable:
    """One variable; a shape is numbers, or names of structural parameters."""

    name: str
    kind: str
    causality: str
    start: object = 0
    shape: tuple[int | str, ...] = ()
    unit: str = ""


def _pairs() -> list[Variable]:
    kinds = ("Float64", "Float32", *INTEGERS, "Boolean", "String", "Enumeration")
    inputs = [Variable(f"{kind}_in", kind, "input", "" if kind == "String" else 0) for kind in kinds]
    inputs += [
        Variable("vector_in", "Float64", "input", 0, (3,), "mm"),
        Variable("matrix_in", "Float64", "input", 0, (2, "columns")),
        Variable("narrow_in", "Float32", "input", 0, (2,)),
        Variable("whole_in", "Int64", "input", 0, (2,)),
        Variable("flags_in", "Boolean", "input", 0, (2,)),
        Variable("words_in", "String", "input", "", (2,)),
    ]
    outputs = [replace(v, name=f"{v.name.removesuffix('_in')}_out", causality="output") for v in inputs]
    return [*inputs, *outputs, Variable("columns", "UInt64", "structuralParameter", 3)]


def _older_pairs() -> list[Variable]:
    kinds = ("Float64", "Int32", "Boolean", "String", "Enumeration")
    inputs = [Variable(f"{_OLDER.get(kind, kind)}_in", kind, "input", "" if kind == "String" else 0) for kind in kinds]
    return inputs + [replace(v, name=f"{v.name.removesuffix('_in')}_out", causality="output") for v in inputs]


DEFAULT_STEP = {"dahlquist": 0.1}  # [s] that a model recommends
MODELS = {
    "integrator": [
        Variable("u", "Float64", "input", 0.0, (), "m/s"),
        Variable("x", "Float64", "output", 0.0, (), "m"),
        Variable("x0", "Float64", "parameter", 1.0, (), "m"),
        Variable("rate", "Float64", "parameter", 0.5),
    ],
    "dahlquist": [
        Variable("x", "Float64", "output", 1.0),
        Variable("k", "Float64", "parameter", 1.0),
    ],
    "stair": [
        Variable("counter", "Int32", "output"),
        Variable("height", "Float64", "output", 0.0),
        Variable("last", "Int32", "parameter", 10),
        Variable("mode", "Int32", "parameter", 0),
        Variable("at", "Int32", "parameter", -1),
    ],
    "resource": [
        Variable("number", "Float64", "output", 0.0),
        Variable("count", "Int32", "output"),
        *(Variable(f"numbers{k}", "Float64", "local", 0.0) for k in range(8)),
    ],
    "ball": [
        Variable("h", "Float64", "output", 0.0, (), "m"),
        Variable("v", "Float64", "output", 0.0, (), "m/s"),
        Variable("bounces", "Int32", "output"),
        Variable("last_bounce", "Float64", "output", 0.0),
        Variable("h0", "Float64", "parameter", 1.0, (), "m"),
        Variable("g", "Float64", "parameter", 9.81),
        Variable("e", "Float64", "parameter", 0.7),
        Variable("v_min", "Float64", "parameter", 0.1, (), "m/s"),
    ],
}


def variables_of(model: str, version: str) -> list[Variable]:
    """Return the variables of a model; its value references are their places in the list."""
    if model == "feedthrough":
        return _pairs() if version == "3.0" else _older_pairs()
    return MODELS[model]


def build(model: str, version: str, folder: Path, *, token: str = TOKEN, more: str = "") -> Path:
    """Compile and zip a model as an FMU of this version; return its path. `more` is put among the variables."""
    folder.mkdir(parents=True, exist_ok=True)
    variables = variables_of(model, version)
    (folder / "variables.h").write_text(_header(model, variables, version))
    fmi, library = int(version[0]), folder / f"{model}.so"
    compile_library(
        library,
        [HERE / f"fmi{fmi}.c", HERE / f"{model}.c"],
        fmi=fmi,
        defines=[quoted("TOKEN", token), f"IDENTIFIER={model}"],
        include=[folder, HERE],
    )
    describe = {1: _description1, 2: _description2, 3: _description3}[fmi]
    files = {"resources/numbers.txt": "\n".join(map(str, NUMBERS))}
    return pack_fmu(folder / f"{model}.fmu", describe(model, variables, more), library, fmi=fmi, files=files)


def _header(model: str, variables: list[Variable], version: str) -> str:
    """Write variables.h; locals of the resource reader are one array of C."""
    types = dict(_C_TYPES) | ({} if version == "3.0" else {"Enumeration": "int32_t"})
    kinds = {"Enumeration": "INT64" if version == "3.0" else "INT32"}
    sizes = {v.name: v.start for v in variables}
    shown = [v for v in variables if v.causality != "local"]
    fields, rows, starts = [], [], []
    for v in shown:
        count = 1
        for size in v.shape:
            count *= int(sizes[size]) if isinstance(size, str) else size
        fields.append(f"    {types[v.kind]} {v.name}{f'[{count}]' if v.shape else ''};")
        rows.append(f"    {{{kinds.get(v.kind, v.kind.upper())}, offsetof(Values, {v.name}), {count}}},")
        if not v.shape:
            starts.append(f".{v.name} = {json.dumps(v.start)}")
    if model == "resource":
        fields.append("    double numbers[8];")
        rows += [f"    {{FLOAT64, offsetof(Values, numbers) + {8 * k}, 1}}," for k in range(8)]
    return (
        f"typedef {_BOOLEANS[version]} BOOL;\n"
        "typedef struct {\n" + "\n".join(fields) + "\n} Values;\n"
        f"enum {{ COUNT = {len(rows)} }};\n"
        "static const Variable VARIABLES[COUNT] __attribute__((unused)) = {\n" + "\n".join(rows) + "\n};\n"
        f"static const Values DEFAULTS __attribute__((unused)) = {{{', '.join(starts)}}};\n"
    )


def _experiment(model: str) -> str:
    """Return the default experiment, if the model recommends a step."""
    step = DEFAULT_STEP.get(model)
    return "" if step is None else f'<DefaultExperiment startTime="0" stopTime="{100 * step:g}" stepSize="{step}"/>'


def _attributes(**values: object) -> str:
    return "".join(f" {name}={quoteattr(str(value))}" for name, value in values.items() if value not in (None, ""))


def _variability(v: Variable) -> str:
    if v.causality in ("parameter", "structuralParameter"):
        return "fixed"
    return "continuous" if v.kind.startswith("Float") else "discrete"


def _text(v: Variable) -> str:
    return str(v.start).lower() if v.kind != "Boolean" else str(bool(v.start)).lower()


def _units() -> str:
    rows = "".join(f'<Unit name="{name}"><BaseUnit {base}/></Unit>' for name, base in UNITS.items())
    return f"<UnitDefinitions>{rows}</UnitDefinitions>"


def _items() -> str:
    return "".join(f'<Item name="{name}" value="{value}"/>' for name, value in ITEMS.items())


def _description3(model: str, variables: list[Variable], more: str) -> str:
    references = {v.name: k for k, v in enumerate(variables)}
    rows = []
    for k, v in enumerate(variables):
        sizes = (f'valueReference="{references[s]}"' if isinstance(s, str) else f'start="{s}"' for s in v.shape)
        inner = "".join(f"<Dimension {size}/>" for size in sizes)
        given = v.causality in ("input", "parameter", "structuralParameter")
        if given and v.kind == "String":
            inner += f"<Start value={quoteattr(str(v.start))}/>" * (v.shape[0] if v.shape else 1)
        rows.append(
            f"<{v.kind}"
            + _attributes(name=v.name, valueReference=k, causality=v.causality, variability=_variability(v))
            + _attributes(
                unit=v.unit,
                declaredType="Mode" if v.kind == "Enumeration" else "",
                start=_text(v) if given and v.kind != "String" else "",
            )
            + f">{inner}</{v.kind}>"
        )
    outputs = [k for k, v in enumerate(variables) if v.causality == "output"]
    structure = "".join(f'<Output valueReference="{k}"/>' for k in outputs)
    structure += "".join(f'<InitialUnknown valueReference="{k}"/>' for k in outputs)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="3.0" modelName="{model}" instantiationToken="{TOKEN}">\n'
        f'<CoSimulation modelIdentifier="{model}" canHandleVariableCommunicationStepSize="true" '
        'canGetAndSetFMUState="true" canSerializeFMUState="true"/>\n'
        f'{_units()}<TypeDefinitions><EnumerationType name="Mode">{_items()}</EnumerationType></TypeDefinitions>\n'
        f"{_experiment(model)}<ModelVariables>\n{chr(10).join(rows)}{more}\n"
        '<Float64 name="time" valueReference="4242" causality="independent" variability="continuous"/>\n'
        f"</ModelVariables>\n<ModelStructure>{structure}</ModelStructure>\n</fmiModelDescription>\n"
    )


def _description2(model: str, variables: list[Variable], more: str) -> str:
    rows = []
    for k, v in enumerate(variables):
        start = _text(v) if v.causality in ("input", "parameter") else None
        kind = _OLDER.get(v.kind, v.kind)
        text = f" start={quoteattr(start)}" if start is not None else ""
        rows.append(
            "<ScalarVariable"
            + _attributes(name=v.name, valueReference=k, causality=v.causality, variability=_variability(v))
            + f"><{kind}{_attributes(unit=v.unit, declaredType='Mode' if kind == 'Enumeration' else '')}{text}/>"
            + "</ScalarVariable>"
        )
    outputs = "".join(f'<Unknown index="{k}"/>' for k, v in enumerate(variables, 1) if v.causality == "output")
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="2.0" modelName="{model}" guid="{TOKEN}">\n'
        f'<CoSimulation modelIdentifier="{model}" canHandleVariableCommunicationStepSize="true" '
        'canGetAndSetFMUstate="true" canSerializeFMUstate="true"/>\n'
        f'{_units()}<TypeDefinitions><SimpleType name="Mode"><Enumeration>{_items()}</Enumeration></SimpleType>'
        f"</TypeDefinitions>\n{_experiment(model)}<ModelVariables>\n{chr(10).join(rows)}{more}\n</ModelVariables>\n"
        f"<ModelStructure><Outputs>{outputs}</Outputs><InitialUnknowns>{outputs}</InitialUnknowns></ModelStructure>\n"
        "</fmiModelDescription>\n"
    )


def _description1(model: str, variables: list[Variable], more: str) -> str:
    rows = []
    for k, v in enumerate(variables):
        parameter = v.causality == "parameter"
        kind = _OLDER.get(v.kind, v.kind)
        text = "1" if kind == "Enumeration" else _text(v)  # items count from 1
        start = f" start={quoteattr(text)}" if parameter or v.causality == "input" else ""
        declared = _attributes(declaredType="Mode") if kind == "Enumeration" else ""
        rows.append(
            "<ScalarVariable"
            + _attributes(
                name=v.name,
                valueReference=k,
                causality="internal" if parameter or v.causality == "local" else v.causality,
                variability="parameter" if parameter else _variability(v),
            )
            + f"><{kind}{declared}{start}/></ScalarVariable>"
        )
    items = "".join(f'<Item name="{name}"/>' for name in ITEMS)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="1.0" modelName="{model}" modelIdentifier="{model}" guid="{TOKEN}" '
        'numberOfContinuousStates="0" numberOfEventIndicators="0">\n'
        f'<TypeDefinitions><Type name="Mode"><EnumerationType>{items}</EnumerationType></Type></TypeDefinitions>\n'
        f"{_experiment(model)}<ModelVariables>\n{chr(10).join(rows)}{more}\n</ModelVariables>\n"
        "<Implementation><CoSimulation_StandAlone><Capabilities/></CoSimulation_StandAlone></Implementation>\n"
        "</fmiModelDescription>\n"
    )
