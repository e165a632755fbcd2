"""Comparison of an FMU with a contract: ports served directly, through an adapter, or not at all."""

from dataclasses import replace

import pytest

from lockstep.check.contract import Contract, ContractPort, choose, compare, split_name
from lockstep.check.contract_findings import contract_findings
from lockstep.check.static.model import Model, parse_xml, read_model
from lockstep.errors import InputError
from lockstep.system.units import Unit

from .conftest import text_of

RATE = Unit(name="rad/s", exponents=(0, 0, -1, 0, 0, 0, 0, 1))
TORQUE = Unit(name="N.m", exponents=(1, 2, -2, 0, 0, 0, 0, 0))
UNITS = """
<Unit name="rad/s"><BaseUnit rad="1" s="-1"/></Unit>
<Unit name="deg/s"><BaseUnit rad="1" s="-1" factor="0.017453292519943295"/></Unit>
<Unit name="1/s"><BaseUnit s="-1"/></Unit>
<Unit name="rpm"><BaseUnit s="-1" factor="0.10471975511965977"/></Unit>
<Unit name="Nm"><BaseUnit kg="1" m="2" s="-2"/></Unit>
<Unit name="mN.m"><BaseUnit kg="1" m="2" s="-2" factor="0.001"/></Unit>
<Unit name="V"><BaseUnit kg="1" m="2" s="-3" A="-1"/></Unit>
"""


def array(name: str, size: int, causality: str, unit: Unit, needed: bool = False) -> tuple[ContractPort, ...]:
    return tuple(
        ContractPort(name=f"{name}[{i}]", type="Real", causality=causality, unit=unit, needed=needed)
        for i in range(1, size + 1)
    )


CONTRACT = Contract(
    component="controller",
    variant="small",
    ports=(
        *array("gyro.rate", 2, "input", RATE),
        *array("wheel.torque", 3, "output", TORQUE, needed=True),
        ContractPort(name="valid", type="Boolean", causality="input"),
        ContractPort(name="torque_limit", type="Real", causality="parameter", unit=TORQUE),
    ),
)
LARGE = replace(
    CONTRACT, variant="large", ports=(*CONTRACT.ports, *array("wheel.torque", 6, "output", TORQUE, True)[3:])
)


def vendor(*variables: tuple[str, str, str]) -> Model:
    """Describe an FMU by name, causality and value element of each variable."""
    scalars = "".join(
        f'<ScalarVariable name="{name}" valueReference="{i}" causality="{causality}">{value}</ScalarVariable>'
        for i, (name, causality, value) in enumerate(variables)
    )
    text = f"<fmiModelDescription><UnitDefinitions>{UNITS}</UnitDefinitions><ModelVariables>{scalars}</ModelVariables>"
    return read_model(parse_xml(f"{text}</fmiModelDescription>".encode()))


def real(unit: str) -> str:
    return f'<Real unit="{unit}"/>' if unit else "<Real/>"


def serving(
    rate: str = "gyro.rate[{}]",
    torque: str = "wheel.torque[{}]",
    units: tuple[str, str] = ("rad/s", "Nm"),
    first: int = 1,
) -> Model:
    """Describe a controller that serves everything, under these names and units."""
    return vendor(
        *((rate.format(i), "input", real(units[0])) for i in range(first, first + 2)),
        *((torque.format(i), "output", real(units[1])) for i in range(first, first + 3)),
        ("valid", "input", "<Boolean/>"),
        ("torque_limit", "parameter", real("Nm")),
    )


def work(model: Model) -> set[tuple[str, str]]:
    """Return what an adapter has to do, by name of the port."""
    return {(served.port.name, line) for served in compare(CONTRACT, model).adapted for line in served.work}


def test_equal_names_and_units_are_served_directly() -> None:
    comparison = compare(CONTRACT, serving())  # N.m under another name is the same unit

    assert [served.port for served in comparison.served_directly] == list(CONTRACT.ports)
    assert not comparison.adapted
    assert not comparison.missing
    assert not comparison.unfed


@pytest.mark.parametrize(
    "name", ["wheel_torque_{}", "wheelTorque[{}]", "WHEEL.TORQUE({})", "wheel.torque.{}", "WheelTorque{}"]
)
def test_other_spelling_needs_an_adapter(name: str) -> None:
    assert work(serving(torque=name)) == {(f"wheel.torque[{i}]", "named differently") for i in (1, 2, 3)}


@pytest.mark.parametrize("name", ["wheel.torque[{}]", "wheel_torque_{}"])
def test_counting_from_zero_shifts_every_element(name: str) -> None:
    comparison = compare(CONTRACT, serving(torque=name, rate="gyro.rate[{}]", first=0))
    pairs = {s.port.name: (s.variable.name, s.work) for s in comparison.served if s.port.name.startswith("wheel")}

    assert pairs == {f"wheel.torque[{i}]": (name.format(i - 1), ("counted from 0",)) for i in (1, 2, 3)}


@pytest.mark.parametrize(
    ("unit", "says"),
    [
        ("deg/s", "unit deg/s instead of rad/s, factor 0.0174532925"),
        ("", "no unit declared; the contract has rad/s"),
        ("1/s", "unit 1/s, whose base units leave out the radian, factor 1"),
        ("rpm", "unit rpm, whose base units leave out the radian, factor 0.104719755"),
    ],
)
def test_other_unit_needs_an_adapter(unit: str, says: str) -> None:
    assert work(serving(units=(unit, "Nm"))) == {("gyro.rate[1]", says), ("gyro.rate[2]", says)}


def test_unit_of_another_quantity_does_not_fit() -> None:
    comparison = compare(CONTRACT, serving(units=("rad/s", "V")))

    assert {port.name for port, _ in comparison.missing} == {"wheel.torque[1]", "wheel.torque[2]", "wheel.torque[3]"}
    assert all("does not convert" in why for _, why in comparison.missing)


def test_other_number_type_needs_an_adapter_and_text_does_not_fit() -> None:
    counted = serving()
    flag = next(v for v in counted.variables if v.name == "valid")
    as_integer = replace(
        counted, variables=tuple(replace(v, type="Integer") if v is flag else v for v in counted.variables)
    )
    as_text = replace(
        counted, variables=tuple(replace(v, type="String") if v is flag else v for v in counted.variables)
    )

    assert work(as_integer) == {("valid", "type Integer instead of Boolean")}
    assert [(port.name, why) for port, why in compare(CONTRACT, as_text).missing] == [
        ("valid", "is of type String, not Boolean")
    ]


def test_input_does_not_serve_an_output() -> None:
    missing = compare(CONTRACT, vendor(("wheel.torque[1]", "input", real("Nm")))).missing

    assert ("wheel.torque[1]", "is an input, not an output") in {(port.name, why) for port, why in missing}


@pytest.mark.parametrize(
    ("ports", "closest"),
    [
        ([("y", "output", "<Real/>")], "none has a port like one of the FMU's"),
        (
            [("valid", "input", "<Boolean/>"), *((f"y{k}", "output", "<Real/>") for k in range(9))],
            "the closest is controller",
        ),
    ],
)
def test_an_fmu_like_no_contract_is_left_to_the_user(ports, closest) -> None:
    (finding,) = contract_findings([CONTRACT], vendor(*ports), None)
    assert finding.status == "skipped"
    assert text_of(finding).startswith(f"matches no contract; {closest}")
    assert text_of(finding).endswith("; choose one with --like")


def test_findings_list_needed_optional_and_unfed_ports() -> None:
    model = vendor(
        *((f"TauCmd_{i}", "output", real("mN.m")) for i in (1, 2, 3)),
        *((f"omega({i})", "input", real("deg/s")) for i in (0, 1)),
        ("valid", "input", "<Boolean/>"),
        ("gain_schedule", "input", "<Real/>"),
    )
    findings = {f.check: f for f in contract_findings([CONTRACT], model, "controller")}

    assert {check: f.status for check, f in findings.items()} == {
        "contract.direct": "pass", "contract.adapter": "pass", "contract.missing": "error", "contract.unfed": "warning",
    }  # fmt: skip
    assert findings["contract.direct"].numbers == {"ports": 7, "direct": 1, "adapter": 0, "missing": 6}
    missing = text_of(findings["contract.missing"])
    assert "needed: wheel.torque[1..3]" in missing
    assert "wheel.torque: matches TauCmd_1 to TauCmd_3 of the FMU in number and unit" in missing
    assert "input, available, not used: gyro.rate[1..2]" in missing
    assert "parameter, optional: torque_limit" in missing
    assert findings["contract.unfed"].details == (
        "omega(0), omega(1), gain_schedule",
        "omega(0) to omega(1): matches gyro.rate of the contract in number and unit",
    )


def test_missing_output_is_a_warning_or_an_error_with_like() -> None:
    model = vendor(*((f"gyro.rate[{i}]", "input", real("rad/s")) for i in (1, 2)), ("valid", "input", "<Boolean/>"))
    short = replace(
        CONTRACT, ports=tuple(p for p in CONTRACT.ports if p.name not in ("wheel.torque[2]", "wheel.torque[3]"))
    )

    status = {like: contract_findings([short], model, like)[2].status for like in (None, "controller:small")}
    assert status == {None: "warning", "controller:small": "error"}


def test_best_variant_is_chosen() -> None:
    for size, variant in ((3, "small"), (6, "large")):
        equal = vendor(*((f"wheel.torque[{i}]", "output", real("Nm")) for i in range(1, size + 1)))
        other = vendor(*((f"TauCmd_{i}", "output", real("Nm")) for i in range(1, size + 1)))
        for contracts in ([CONTRACT, LARGE], [LARGE, CONTRACT]):
            for model in (equal, other):
                comparison = choose(contracts, model, "controller")
                assert comparison is not None
                assert comparison.contract.variant == variant


def test_fmu_that_matches_no_contract_is_skipped() -> None:
    findings = contract_findings([CONTRACT, LARGE], vendor(("h", "output", "<Real/>")), None)

    assert [f.status for f in findings] == ["skipped"]
    assert "--like" in findings[0].message
    assert contract_findings([], vendor(), None) == []


def test_unknown_contract_is_refused() -> None:
    with pytest.raises(InputError, match=r"--like thruster: no such contract; there are controller, controller:small"):
        choose([CONTRACT], vendor(), "thruster")


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("wheel.torque[12]", ("wheeltorque", 12)),
        ("TauCmd_1", ("taucmd", 1)),
        ("u(3)", ("u", 3)),
        ("bus.q[0]", ("busq", 0)),
        ("energy", ("energy", None)),
        ("7", ("7", None)),
    ],
)
def test_names_are_split_without_case_and_separators(name: str, parts: tuple[str, int | None]) -> None:
    assert split_name(name) == parts
