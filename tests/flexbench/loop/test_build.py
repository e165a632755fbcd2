"""Packages, metadata, manifest and interface document of a build agree with each other and with the FMUs."""

from __future__ import annotations

import hashlib
import json
import shutil
import zipfile
from importlib.metadata import version
from xml.etree import ElementTree

import pytest
from pyssp_standard.srmd import SRMD

from flexbench.loop import build
from flexbench.loop.build import build_all
from flexbench.loop.build_manifest import MANIFEST, earlier_folders
from flexbench.loop.build_options import ONLY_PYTHON, BuildOptions
from flexbench.loop.scenarios import SCENARIOS
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.errors import BuildError
from flexsat.fmu.export import BuiltFmu
from lockstep import InputError, load_system, read_signals, simulate


@pytest.fixture
def manifest(delivered):
    return json.loads((delivered / MANIFEST).read_text())


def is_twin(name):
    """Return whether a file belongs to the FMUs with flat names, or to those in C."""
    return name.split("/")[1] in ("flat", "native")


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_manifest_lists_every_file_with_its_hash(delivered, manifest):
    listed = {}
    for entry in manifest["configurations"].values():
        listed |= {**entry["fmus"], **entry["files"]}
    found = {str(p.relative_to(delivered)) for p in delivered.rglob("*") if p.is_file() and p.parent != delivered}
    assert set(listed) == found
    assert {name: facts["sha256"] for name, facts in listed.items()} == {
        name: sha256(delivered / name) for name in found
    }


def test_manifest_gives_guids_versions_and_parameters(delivered, manifest):
    for entry in manifest["configurations"].values():
        assert entry["versions"]["numpy"] == version("numpy")
        assert entry["parameters"]["plate"]["flexural_rigidity"] == 8.4e4
        for name, facts in entry["fmus"].items():
            with zipfile.ZipFile(delivered / name) as archive:
                root = ElementTree.fromstring(archive.read("modelDescription.xml"))
            assert root.get("guid") == facts["guid"]
    assert manifest["configurations"]["distributed"]["parameters"]["wheel"]["torque_limit"] == 0.8
    assert manifest["scenarios"]["slew"]["controller"]["command.start_time"] == 5.0


@pytest.mark.parametrize("name", CONFIGURATIONS)
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_metadata_of_a_package_gives_the_hash_of_package_and_fmus(delivered, manifest, name, scenario):
    package = delivered / name / f"{scenario}.ssp"
    with SRMD(package.with_suffix(".srmd")) as metadata:
        assert metadata.data == package.name
        assert metadata.checksum == hashlib.sha3_256(package.read_bytes()).hexdigest()
        entries = {e.keyword: e.text for c in metadata.classifications for e in c.classification_entries}
    structured = {file: facts for file, facts in manifest["configurations"][name]["fmus"].items() if not is_twin(file)}
    assert len(structured) == 3
    for file, facts in structured.items():
        component = file.split("/")[1].split(".")[0]
        assert entries[f"{component}.guid"] == facts["guid"]
        with zipfile.ZipFile(package) as archive:
            inside = hashlib.sha256(archive.read(f"resources/{component}.fmu")).hexdigest()
        assert entries[f"{component}.sha256"] == facts["sha256"] == inside
    assert entries["controller.open_loop"] == str(scenario == "fine_pointing_open_loop").lower()


def test_package_gives_the_results_of_its_system_file(delivered, tmp_path):
    for suffix in ("ssd", "ssp"):
        system = load_system(delivered / "centralised" / f"fine_pointing.{suffix}")
        simulate(system, tmp_path / suffix, stop_time=0.05)
    a, b = (read_signals(tmp_path / suffix).columns for suffix in ("ssd", "ssp"))
    assert all((a[name] == b[name]).all() for name in a)


def test_building_one_configuration_keeps_the_unchanged_other(delivered, tmp_path, manifest, monkeypatch):
    """The FMUs themselves are not built again: test_built_components compares their bytes."""
    shutil.copytree(delivered, tmp_path, dirs_exist_ok=True)
    monkeypatch.setattr(build, "configuration_parts", lambda _: {})
    monkeypatch.setattr(build, "build_configuration", lambda *_: built_before(manifest, tmp_path))

    build_all(("centralised",), tmp_path, lambda _: None, ONLY_PYTHON)

    rebuilt = json.loads((tmp_path / MANIFEST).read_text())
    for group in ("fmus", "files"):  # its twins were not built again, and are still there
        listed = rebuilt["configurations"]["centralised"][group]
        earlier = {name for name, facts in listed.items() if facts.pop("earlier_build", False)}
        assert earlier == {name for name in manifest["configurations"]["centralised"][group] if is_twin(name)} != set()
    assert rebuilt == manifest
    assert earlier_folders(tmp_path) == [tmp_path / "centralised" / kind for kind in ("flat", "flat/native", "native")]
    lines = (delivered / "ICD.md").read_text().splitlines()
    assert (tmp_path / "ICD.md").read_text().splitlines() == [
        line for line in lines if "centralised/flat" not in line and "centralised/native" not in line
    ]

    with (tmp_path / "distributed" / "plant.fmu").open("ab") as file:
        file.write(b"x")
    build_all(("centralised",), tmp_path, lambda _: None, ONLY_PYTHON)
    assert list(json.loads((tmp_path / MANIFEST).read_text())["configurations"]) == ["centralised"]
    assert "distributed/plant.fmu" not in (tmp_path / "ICD.md").read_text()

    def fail(*_):
        raise BuildError("cc cannot compile plant_centralised: no")

    monkeypatch.setattr(build, "build_native_configuration", fail)
    reason = r"^cc cannot compile plant_centralised: no; --no-native leaves out the FMUs in C$"
    with pytest.raises(InputError, match=reason):
        build_all(("centralised",), tmp_path, lambda _: None)
    reasons = []
    build_all(("centralised",), tmp_path, lambda _: None, without_native=reasons.append)
    assert reasons == ["cc cannot compile plant_centralised: no"]
    entry = json.loads((tmp_path / MANIFEST).read_text())["configurations"]["centralised"]
    in_c = [facts for part in ("fmus", "files") for name, facts in entry[part].items() if "native" in name]
    assert in_c
    assert all(facts["earlier_build"] for facts in in_c)


def test_fmus_of_fmi_3_have_a_folder_with_systems_in_the_manifest(delivered, tmp_path, manifest, monkeypatch):
    layout = tmp_path / "centralised"
    shutil.copytree(delivered / "centralised", layout, ignore=shutil.ignore_patterns("flat", "*.ssp"))

    def in_c(_designs, folder, _parts, _print_line, fmi, _platforms):  # they have tests of their own
        assert (folder, fmi) == (tmp_path, "3.0")
        shutil.copytree(layout / "native", layout / "native" / "fmi3")
        paths = [layout / "native" / "fmi3" / f"{name}.fmu" for name in ("plant", "sensors", "controller")]
        return {path.stem: BuiltFmu(path=path, guid="{3}", sha256=sha256(path)) for path in paths}

    monkeypatch.setattr(build, "configuration_parts", lambda _: {})
    monkeypatch.setattr(build, "build_configuration", lambda *_: built_before(manifest, tmp_path))
    monkeypatch.setattr(build, "build_native_configuration", in_c)
    build_all(("centralised",), tmp_path, lambda _: None, BuildOptions(in_c=("3.0",)))

    entry = json.loads((tmp_path / MANIFEST).read_text())["configurations"]["centralised"]
    of_fmi3 = {name: facts["component"] for name, facts in entry["fmus"].items() if "native" in name}
    folder = "centralised/native/fmi3"
    assert of_fmi3 == {f"{folder}/{name}.fmu": f"{name}, FMI 3.0" for name in ("plant", "sensors", "controller")}
    for scenario in SCENARIOS:
        file = f"{folder}/{scenario}.ssd"
        assert entry["files"][file] == {"sha256": sha256(tmp_path / file)}
        components = load_system(tmp_path / file).components
        assert {component.source for component in components} == {tmp_path / name for name in of_fmi3}


def built_before(manifest, folder):
    """Return the structured FMUs of the centralised configuration as `build_configuration` returns them."""
    return {
        facts["component"]: BuiltFmu(path=folder / name, guid=facts["guid"], sha256=facts["sha256"])
        for name, facts in manifest["configurations"]["centralised"]["fmus"].items()
        if not is_twin(name)
    }


def test_a_folder_for_objects_that_cannot_be_written_to_is_refused_before_anything_is_built(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("FLEXSAT_OBJECTS", str(tmp_path / "file" / "objects"))

    with pytest.raises(InputError, match=r"FLEXSAT_OBJECTS=.*objects: Not a directory; name a folder"):
        build_all(("centralised",), tmp_path / "fmus")

    assert not (tmp_path / "fmus").exists()
