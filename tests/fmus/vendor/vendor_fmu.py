"""Compile the foreign controller of vendor.c, and write adapter files for it."""

from __future__ import annotations

import zipfile
from pathlib import Path

from fmus.c_fmu import compile_library, pack_fmu, quoted

HERE = Path(__file__).parent
GUID = "{0c7f5b2e-64b1-4d58-8a2f-0e0b7c1f9a41}"
UNITS = """
  <UnitDefinitions>
    <Unit name="deg/s"><BaseUnit rad="1" s="-1" factor="0.017453292519943295"/></Unit>
    <Unit name="rpm"><BaseUnit rad="1" s="-1" factor="0.10471975511965977"/></Unit>
    <Unit name="mN.m"><BaseUnit kg="1" m="2" s="-2" factor="0.001"/></Unit>
  </UnitDefinitions>"""

ADAPTER = """\
step = 0.01
ignore = ["StatusWord"]

[[input]]
port = "star_tracker.mrp"
variable = "q_IB[*]"
index_base = 0
attitude = "quaternion"
scalar = "first"
direction = "inertial-from-body"

[[input]]
port = "gyro.rate[1..3]"
variable = "w_meas[*]"
index_base = 0
unit = "deg/s"

[[input]]
port = "star_tracker.valid"
variable = "q_ok"
true = 3

[[input]]
port = "encoder.speed"
variable = "whl_n[*]"
index_base = 0
unit = "rpm"

[[output]]
port = "wheel.torque"
variable = "TauCmd[*]"
index_base = 0
unit = "mN.m"

[constants]
Mode = 2

[substitutes]
"reference.*" = 0.0
"""


def vendor_fmu(folder: Path, *, units: bool = True) -> Path:
    """Compile and zip the controller, with units declared or without; return its path."""
    library = folder / "vendor.so"
    compile_library(library, [HERE / "vendor.c"], defines=[quoted("GUID", GUID)])
    return pack_fmu(folder / "vendor.fmu", _description(units), library)


def _description(units: bool) -> str:
    rows = [(f"q_IB[{k}]", "input", "") for k in range(4)]
    rows += [(f"w_meas[{k}]", "input", "deg/s") for k in range(3)]
    rows += [(f"whl_n[{k}]", "input", "rpm") for k in range(6)]
    rows += [(f"TauCmd[{k}]", "output", "mN.m") for k in range(6)]
    rows += [("kp", "parameter", ""), ("kd", "parameter", ""), ("tau_max", "parameter", "mN.m")]
    starts = {"q_IB[0]": 1.0, "kp": 0.02, "kd": 0.2, "tau_max": 4400.0}
    variables = [
        _variable(name, k, causality, "Real", starts.get(name, 0.0), unit if units else "")
        for k, (name, causality, unit) in enumerate(rows)
    ]
    words = (("q_ok", "input"), ("Mode", "input"), ("StatusWord", "output"))
    variables += [_variable(name, k, causality, "Integer", 0, "") for k, (name, causality) in enumerate(words)]
    outputs = "".join(
        f'<Unknown index="{k}"/>' for k, text in enumerate(variables, start=1) if 'causality="output"' in text
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="2.0" modelName="vendor" guid="{GUID}">\n'
        '  <CoSimulation modelIdentifier="vendor" canBeInstantiatedOnlyOncePerProcess="true"/>'
        f'{UNITS if units else ""}\n  <DefaultExperiment stepSize="0.01"/>\n  <ModelVariables>\n'
        + "\n".join(variables)
        + f"\n  </ModelVariables>\n  <ModelStructure><Outputs>{outputs}</Outputs>"
        f"<InitialUnknowns>{outputs}</InitialUnknowns></ModelStructure>\n</fmiModelDescription>\n"
    )


def _variable(name: str, reference: int, causality: str, kind: str, start: float, unit: str) -> str:
    given = "" if causality == "output" else f' start="{start}"'
    variability = "fixed" if causality == "parameter" else "discrete"
    unit = f' unit="{unit}"' if unit else ""
    return (
        f'    <ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}" '
        f'variability="{variability}"><{kind}{given}{unit}/></ScalarVariable>'
    )


FOREIGN_ADAPTER = """\
ignore = ["reference.*", "estimate.*"]

[[input]]
port = "star_tracker.mrp"
variable = "q_IB[*]"
attitude = "quaternion"
scalar = "first"
direction = "inertial-from-body"
body_frame = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]

[[input]]
port = "gyro.rate"
variable = "w_meas[*]"
unit = "deg/s"
order = [23, 22, 21, 20, 19, 18, 17, 16, 15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1]

[[input]]
port = "star_tracker.valid"
variable = "q_ok"
true = 7
false = -7

[[output]]
port = "wheel.torque"
variable = "tau_cmd[*]"
unit = "mN.m"
sign = -1

[parameters]
"star_tracker.fine" = true
""" + "".join(
    f'\n[[input]]\nport = "{name}"\nvariable = "{variable}"\n'
    for name, variable in (
        ("accelerometer.acceleration", "accelerometer.acceleration[*]"),
        ("encoder.speed", "encoder.speed[*]"),
        ("encoder.angle", "encoder.angle[*]"),
        ("command.rotation", "command.rotation[*]"),
        ("command.start_time", "command.start_time"),
        ("applied.wheel.torque", "applied.wheel.torque[*]"),
        ("applied.valid", "applied.valid"),
    )
)


def foreign_fmu(path: Path, controller: Path) -> None:
    """Build our controller in foreign conventions, with the design of the given one."""
    import flexsat
    from flexsat.fmu.export import build_fmu

    with zipfile.ZipFile(controller) as archive:
        model = archive.read("resources/model.npz")
    flexsat.__path__.append(str(HERE))
    try:
        build_fmu("flexsat.foreign.controller:ForeignController", path, {"model.npz": model}, "foreign_controller")
    finally:
        flexsat.__path__.remove(str(HERE))
