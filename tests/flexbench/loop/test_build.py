"""What a build leaves beside the FMUs: packages, meta data, manifest; true, and in step with each other."""

from __future__ import annotations

import hashlib
import json
import zipfile
from importlib.metadata import version
from xml.etree import ElementTree

import pytest
from pyssp_standard.srmd import SRMD

from flexbench.loop.build import build_all
from flexbench.loop.build_manifest import MANIFEST
from flexbench.loop.scenarios import SCENARIOS
from flexsat.parameters import CONFIGURATIONS
from lockstep import load_system, read_signals, simulate


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """Return a folder that holds a whole build."""
    folder = tmp_path_factory.mktemp("fmus")
    build_all(CONFIGURATIONS, folder, lambda _: None)
    return folder


@pytest.fixture
def manifest(fmus):
    return json.loads((fmus / MANIFEST).read_text())


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_the_manifest_lists_every_file_with_its_hash(fmus, manifest):
    listed = {}
    for entry in manifest["configurations"].values():
        listed |= {**entry["fmus"], **entry["files"]}
    there = {str(p.relative_to(fmus)) for p in fmus.rglob("*") if p.is_file() and p.parent != fmus}
    assert set(listed) == there
    assert {name: facts["sha256"] for name, facts in listed.items()} == {name: sha256(fmus / name) for name in there}


def test_the_manifest_tells_guids_versions_and_parameters(fmus, manifest):
    for entry in manifest["configurations"].values():
        assert entry["versions"]["numpy"] == version("numpy")
        assert entry["parameters"]["plate"]["flexural_rigidity"] == 8.4e4
        for name, facts in entry["fmus"].items():
            with zipfile.ZipFile(fmus / name) as archive:
                root = ElementTree.fromstring(archive.read("modelDescription.xml"))
            assert root.get("guid") == facts["guid"]
    assert manifest["configurations"]["distributed"]["parameters"]["wheel"]["torque_limit"] == 0.8
    assert manifest["scenarios"]["slew"]["controller"]["command.start_time"] == 5.0


@pytest.mark.parametrize("name", CONFIGURATIONS)
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_the_meta_data_beside_a_package_names_its_bytes_and_fmus(fmus, manifest, name, scenario):
    package = fmus / name / f"{scenario}.ssp"
    with SRMD(package.with_suffix(".srmd")) as described:
        assert described.data == package.name
        assert described.checksum == hashlib.sha3_256(package.read_bytes()).hexdigest()
        said = {e.keyword: e.text for c in described.classifications for e in c.classification_entries}
    for file, facts in manifest["configurations"][name]["fmus"].items():
        component = file.split("/")[1].split(".")[0]
        assert said[f"{component}.guid"] == facts["guid"]
        with zipfile.ZipFile(package) as archive:
            inside = hashlib.sha256(archive.read(f"resources/{component}.fmu")).hexdigest()
        assert said[f"{component}.sha256"] == facts["sha256"] == inside
    assert said["controller.open_loop"] == str(scenario == "fine_pointing_open_loop").lower()


def test_a_package_gives_the_results_of_its_system_file(fmus, tmp_path):
    for suffix in ("ssd", "ssp"):
        system = load_system(fmus / "centralised" / f"fine_pointing.{suffix}")
        simulate(system, tmp_path / suffix, stop_time=0.05)
    a, b = (read_signals(tmp_path / suffix).columns for suffix in ("ssd", "ssp"))
    assert all((a[name] == b[name]).all() for name in a)


def test_building_one_configuration_keeps_what_is_true_of_the_other(fmus, tmp_path, manifest):
    for path in fmus.rglob("*"):
        if path.is_file():
            (tmp_path / path.relative_to(fmus)).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / path.relative_to(fmus)).write_bytes(path.read_bytes())
    build_all(("centralised",), tmp_path, lambda _: None)
    assert json.loads((tmp_path / MANIFEST).read_text()) == manifest
    assert (tmp_path / "ICD.md").read_bytes() == (fmus / "ICD.md").read_bytes()
    with (tmp_path / "distributed" / "plant.fmu").open("ab") as file:
        file.write(b"x")
    build_all(("centralised",), tmp_path, lambda _: None)
    assert list(json.loads((tmp_path / MANIFEST).read_text())["configurations"]) == ["centralised"]
    assert "distributed/plant.fmu" not in (tmp_path / "ICD.md").read_text()
