"""Our components as contracts: the ports that our FMUs really have."""

import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from flexbench.adapt.contracts import contracts, contracts_of
from lockstep.check.contract import choose, compare
from lockstep.check.contract_findings import contract_findings
from lockstep.check.static.model import Model, parse_xml, read_model


@pytest.fixture(scope="module")
def models(delivered: Path) -> dict[str, Model]:
    """Return the model description of each centralised FMU."""
    return {path.stem: description(path) for path in (delivered / "centralised").glob("*.fmu")}


def description(path: Path) -> Model:
    with zipfile.ZipFile(path) as archive:
        return read_model(parse_xml(archive.read("modelDescription.xml")))


def test_each_component_and_configuration_has_a_contract() -> None:
    names = [contract.name for contract in contracts()]

    assert len(names) == len(set(names)) == 6
    assert {"controller:distributed", "plant:centralised"} <= set(names)


@pytest.mark.parametrize("component", ["plant", "sensors", "controller"])
def test_fmu_serves_its_own_contract_completely(models: dict[str, Model], component: str) -> None:
    comparison = choose(contracts(), models[component], None)

    assert comparison is not None
    assert comparison.contract.name == f"{component}:centralised"
    assert not comparison.adapted
    assert not comparison.missing
    assert not comparison.unfed
    assert {f.status for f in contract_findings(contracts(), models[component], None)} == {"pass"}


def test_the_loop_needs_the_torques_of_a_controller_and_the_measurements_of_sensors() -> None:
    needed = {
        contract.component: {port.name.partition("[")[0] for port in contract.ports if port.needed}
        for contract in contracts_of("distributed")
    }

    assert needed["controller"] == {"wheel.torque"}
    assert {"gyro.rate", "star_tracker.valid", "jitter.force_x"} <= needed["sensors"]
    assert "energy" not in needed["plant"]


def test_flat_variant_needs_an_adapter_for_its_names_only(models: dict[str, Model]) -> None:
    """As an exporter without structured names would write them: wheel_torque_1."""
    (contract,) = [c for c in contracts_of("centralised") if c.component == "controller"]
    controller = models["controller"]
    flat = replace(
        controller,
        variables=tuple(
            replace(v, name=v.name.replace(".", "_").replace("[", "_").replace("]", "")) for v in controller.variables
        ),
    )
    comparison = compare(contract, flat)

    assert not comparison.missing
    assert not comparison.unfed
    assert {line for served in comparison.adapted for line in served.work} == {"named differently"}
    assert {s.port.name for s in comparison.served_directly} == {"as_published", "design", "open_loop"}
