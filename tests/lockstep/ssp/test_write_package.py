"""An .ssp of a system file runs the same from anywhere; its meta data is valid and names its bytes."""

import hashlib
import zipfile
from dataclasses import replace
from importlib.resources import files

import pytest
from lxml import etree
from xmlschema import XMLSchema11

from lockstep import InputError, load_system, read_signals, simulate, write_ssd
from lockstep.ssp.package_members import package_entries
from lockstep.ssp.traceability import srmd_bytes

SCHEMAS = files("pyssp_standard") / "resources"


def pack(entries, path):
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in entries.items():
            archive.writestr(name, content)


def test_package_runs_like_its_system_file(loop_ssd, tmp_path):
    entries = package_entries(loop_ssd)
    assert sorted(entries) == [
        "SystemStructure.ssd",
        "resources/toy_counter.fmu",
        "resources/toy_echo.fmu",
        "resources/toy_integrator.fmu",
    ]
    elsewhere = tmp_path / "else where"
    elsewhere.mkdir()
    pack(entries, elsewhere / "loop.ssp")
    for name, source in (("a", loop_ssd), ("b", elsewhere / "loop.ssp")):
        simulate(load_system(source), tmp_path / name, record=("all",))
    a, b = (read_signals(tmp_path / name).columns for name in "ab")
    assert len(a) > 5
    assert list(a) == list(b)
    assert all((a[name] == b[name]).all() for name in a)


def test_two_files_of_one_name_are_kept_apart(loop, tmp_path):
    parts = []
    for number, component in enumerate(loop.components):
        (tmp_path / str(number)).mkdir()
        fmu = tmp_path / str(number) / "model.fmu"
        fmu.write_bytes(component.source.read_bytes())
        parts.append(replace(component, source=fmu))
    write_ssd(replace(loop, components=tuple(parts)), tmp_path / "s.ssd")
    entries = package_entries(tmp_path / "s.ssd")
    assert set(entries) - {"SystemStructure.ssd"} == {
        "resources/model.fmu",
        "resources/model_2.fmu",
        "resources/model_3.fmu",
    }
    assert entries["resources/model_3.fmu"] == loop.components[2].source.read_bytes()


def test_unreadable_file_is_named(loop_ssd, tmp_path):
    with pytest.raises(InputError, match=r"none\.ssd: cannot read the system description"):
        package_entries(tmp_path / "none.ssd")
    (tmp_path / "moved").mkdir()
    text = loop_ssd.read_bytes().replace(b"toy_echo.fmu", b"toy_gone.fmu")
    (tmp_path / "moved" / "s.ssd").write_bytes(text)
    with pytest.raises(InputError, match=r"s\.ssd: cannot read .*toy_.*\.fmu, which it names \(No such file"):
        package_entries(tmp_path / "moved" / "s.ssd")


def test_system_that_refers_to_another_is_not_packaged_alone(loop_ssd):
    text = loop_ssd.read_text()
    loop_ssd.write_text(
        text.replace('type="application/x-fmu-sharedlibrary"', 'type="application/x-ssp-definition"', 1)
    )
    with pytest.raises(
        InputError, match=r"loop\.ssd: counter: refers to another system; package it by hand, or flatten"
    ):
        package_entries(loop_ssd)


def test_meta_data_is_valid_and_has_the_checksum():
    content = b"the package"
    written = srmd_bytes(
        "loop", "loop.ssp", content, {"org.example.versions": {"numpy": "2.0"}}, {"description": "a <loop>"}
    )
    root = etree.fromstring(written)
    schema = XMLSchema11(str(SCHEMAS / "SRMD11.xsd"))
    schema.validate(written)
    assert not schema.is_valid(written.replace(b"keyword=", b"word="))
    assert root.get("checksum") == hashlib.sha3_256(content).hexdigest()
    assert root.get("data") == "loop.ssp"
    (entry,) = root.iter("{*}ClassificationEntry")
    assert (entry.get("keyword"), entry.text) == ("numpy", "2.0")
