"""`flexsat check` judges a vendor's FMU behind its adapter, and points to `adapt` without one."""

import shutil

import pytest

from flexbench.adapt.contracts import contracts_of
from flexbench.cli.check import _behind
from flexbench.cli.parser import main
from fmus.vendor.vendor_fmu import ADAPTER, vendor_fmu
from lockstep.check.adapted_findings import adapted_findings
from lockstep.check.contract_findings import contract_findings
from lockstep.check.static.fmu_archive import read_archive

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the foreign controller is compiled with gcc")
WRONG = ADAPTER.replace('"inertial-from-body"', '"body-from-inertial"')
WITHOUT_TORQUE = (
    ADAPTER[: ADAPTER.index("[[output]]")].replace('"StatusWord"', '"StatusWord", "TauCmd*"')
    + ADAPTER[ADAPTER.index("[constants]") :]
)


@pytest.fixture(scope="module")
def vendor(tmp_path_factory):
    """Return the FMU of the foreign controller."""
    return vendor_fmu(tmp_path_factory.mktemp("vendor"))


@pytest.fixture(scope="module")
def offered():
    """Return the contracts of one configuration."""
    return contracts_of("centralised")


@pytest.mark.parametrize(
    ("text", "like", "statuses", "says"),
    [
        (ADAPTER, "controller", {"adapter": "pass", "missing": "info", "conventions": "pass"},
         "right: the torque opposes each attitude and rate error"),
        (WRONG, None, {"adapter": "pass", "missing": "info", "conventions": "error"},
         'wrong: inverse rotation: input 1 (q_IB[*]): write direction = "inertial-from-body"'),
        (WITHOUT_TORQUE, "controller", {"adapter": "pass", "missing": "error"},
         "the system needs wheel.torque[1..6]; add an [[output]], or [substitutes]"),
        (ADAPTER, "plant", {"adapter": "error"}, "vendor.toml does not fit: plant:centralised: vendor.toml: input 1"),
    ],
)  # fmt: skip
def test_fmu_is_judged_behind_its_adapter(vendor, offered, tmp_path, text, like, statuses, says):
    (tmp_path / "vendor.toml").write_text(text)
    behind = _behind(tmp_path / "vendor.toml", [vendor])
    found = adapted_findings(offered, vendor, like, behind, dynamic=True)

    assert {f.check.removeprefix("contract."): f.status for f in found} == statuses
    assert found[-1].message.startswith(says)
    if statuses["adapter"] == "pass":
        assert "input gyro.rate[1..3] is w_meas[0..2]" in found[0].details


def test_without_an_adapter_the_report_points_to_adapt(vendor, offered):
    found = {f.check: f for f in contract_findings(offered, read_archive(vendor).model, "controller")}

    assert found["contract.missing"].status == "error"
    assert found["contract.missing"].message.endswith(
        "draft one with `adapt`, --like controller:centralised, and give it to this check as --adapter FILE"
    )


def test_adapter_is_for_one_fmu_and_has_to_exist(vendor, tmp_path, capsys):
    lines = []
    for words in (["--adapter", str(tmp_path / "none.toml"), str(vendor)],
                  ["--adapter", str(tmp_path / "none.toml"), str(vendor), str(vendor)]):  # fmt: skip
        assert main(["check", "--static", *words]) == 2
        lines.append(capsys.readouterr().err)

    assert "adapter: no such file" in lines[0]
    assert "is for one FMU, and 2 are given; check each by itself" in lines[1]
