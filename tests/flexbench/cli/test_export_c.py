"""The command `flexsat export-c`: what its options change, and what it refuses."""

from dataclasses import fields, replace

import pytest

from flexbench.cli.parser import main
from flexsat.description.built_in import configuration
from flexsat.design.chain import build_design
from flexsat.fmu.reproducible_zip import npz_bytes, zip_bytes
from flexsat.parameters import PUBLISHED_MODES
from flexsat.spacecraft.variation import with_modes


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """Return a folder with what the command reads of an FMU: the matrices of two designs."""
    folder = tmp_path_factory.mktemp("fmus")
    given = build_design(with_modes(configuration("centralised", "published"), PUBLISHED_MODES)).controller
    few = replace(given, gain_coarse=given.gain_coarse[:1], gain_fine=given.gain_fine[:1])
    variants = {"corrected": few, "published": replace(few, feedback=0.5 * few.feedback)}
    arrays = {f"{name}.{field.name}": getattr(matrices, field.name) for name, matrices in variants.items()
              for field in fields(matrices)}  # fmt: skip
    (folder / "centralised").mkdir()
    content = zip_bytes({"resources/model.npz": npz_bytes(arrays)})
    (folder / "centralised" / "controller.fmu").write_bytes(content)
    return folder


def export(fmus, out, *options):
    words = ["export-c", "controller", "--configuration", "centralised", "--fmus", str(fmus), "--out", str(out)]
    return main([*words, *options])


def test_every_option_changes_what_is_written(fmus, tmp_path, capsys):
    headers, data = {}, {}
    for name, options in {
        "plain": (),
        "float": ("--precision", "float"),
        "published": ("--design", "published"),
    }.items():
        assert export(fmus, tmp_path / name, *options) == 0
        folder = tmp_path / name / "centralised"
        count, path = capsys.readouterr().out.splitlines()
        assert count == f"{len(list(folder.iterdir()))} files; interface in flexsat_controller.h, use in README.md:"
        assert path == str(folder)
        headers[name] = (folder / "flexsat_controller.h").read_text()
        data[name] = (folder / "data.c").read_bytes()

    assert "typedef double FlexsatReal;" in headers["plain"]
    assert "typedef float FlexsatReal;" in headers["float"]
    assert "centralised layout, robust design, in doubles" in headers["plain"]
    assert "centralised layout, published design, in doubles" in headers["published"]
    assert data["plain"] == data["float"] != data["published"]
    identities = {header.partition("#define FLEXSAT_DESIGN ")[2].partition(")")[0] for header in headers.values()}
    assert len(identities) == 3
    assert (tmp_path / "plain" / "centralised" / "Makefile").read_text().count("\t") == 1


def test_an_export_is_written_again_beside_what_was_made_of_it(fmus, tmp_path):
    assert export(fmus, tmp_path) == 0
    (tmp_path / "centralised" / "example").write_bytes(b"built")
    assert export(fmus, tmp_path, "--precision", "float") == 0

    assert (tmp_path / "centralised" / "example").read_bytes() == b"built"
    assert "typedef float" in (tmp_path / "centralised" / "flexsat_controller.h").read_text()


def refused(capsys, code):
    shown = capsys.readouterr()
    assert (code, shown.out, shown.err.count("\n")) == (2, "", 1)
    return shown.err


def test_bad_input_is_one_line_and_nothing_is_written(fmus, tmp_path, capsys):
    out = tmp_path / "out"
    assert "flexsat: COMPONENT: 'plant' is none of controller" in refused(capsys, main(["export-c", "plant"]))
    assert "--precision: 'half' is none of double, float" in refused(capsys, export(fmus, out, "--precision", "half"))
    missing = refused(capsys, export(tmp_path / "none", out))
    assert f"{tmp_path / 'none' / 'centralised' / 'controller.fmu'}: no such file; `flexsat build` makes" in missing
    assert not out.exists()


def test_files_of_others_are_kept(fmus, tmp_path, capsys):
    (tmp_path / "centralised").mkdir()
    (tmp_path / "centralised" / "main.c").write_text("int main(void) { return 0; }\n")

    assert "holds files that are no exported controller; name a new or an empty" in refused(
        capsys, export(fmus, tmp_path)
    )
    assert [path.name for path in (tmp_path / "centralised").iterdir()] == ["main.c"]


def test_an_fmu_of_others_is_refused(tmp_path, capsys):
    (tmp_path / "centralised").mkdir()
    fmu = tmp_path / "centralised" / "controller.fmu"
    for content in (b"no archive", zip_bytes({"modelDescription.xml": b""}), zip_bytes({"resources/model.npz": b""})):
        fmu.write_bytes(content)
        assert f"flexsat: {fmu}: no controller of flexsat (" in refused(capsys, export(tmp_path, tmp_path / "out"))
    assert not (tmp_path / "out").exists()
