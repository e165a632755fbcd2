"""Systems of native FMUs, as files for other tools and with all that a run can have: the results of those in Python."""

import hashlib
import json
import shutil
import zipfile

import numpy as np
import pytest
from pyssp_standard.srmd import SRMD

from flexbench.cli.parser import main
from flexbench.loop.build_manifest import MANIFEST
from flexbench.loop.equivalence import compare_folders
from flexbench.loop.native_fmus import is_native, with_native_fmus
from lockstep import load_system, read_signals, simulate, write_ssd
from lockstep.results.read_run_record import read_run_record

DURATION = 0.05  # s
SAME = 1e-10  # of the largest value: rounding


def as_flat(name):
    """Return the name of a signal in a system of FMUs with flat names."""
    component, _, variable = name.partition(".")
    return f"{component}.{variable.replace('.', '_').replace('[', '_').removesuffix(']')}"


def columns(folder):
    return read_signals(folder).columns


@pytest.fixture(scope="module")
def flown(delivered, tmp_path_factory):
    """Return the signals of the centralised native system."""
    folder = tmp_path_factory.mktemp("native") / "run"
    simulate(load_system(delivered / "centralised" / "native" / "fine_pointing.ssd"), folder, stop_time=DURATION)
    return columns(folder)


@pytest.mark.parametrize("file", ["fine_pointing.ssp", "closed/fine_pointing.ssd", "closed/fine_pointing.ssp"])
def test_packages_and_closed_systems_give_the_same_bits(delivered, tmp_path, flown, file):
    system = load_system(delivered / "centralised" / "native" / file)
    assert all(is_native(component) for component in system.components)
    assert bool(system.ports) == (not file.startswith("closed"))
    simulate(system, tmp_path / "run", stop_time=DURATION)
    for name, values in columns(tmp_path / "run").items():
        np.testing.assert_array_equal(values, flown[name], name)


def test_flat_names_change_nothing_else_and_native_finds_them(delivered, tmp_path, flown):
    native = load_system(delivered / "centralised" / "flat" / "native" / "fine_pointing.ssd")
    system = with_native_fmus(load_system(delivered / "centralised" / "flat" / "fine_pointing.ssd"))
    assert [c.source for c in system.components] == [c.source for c in native.components]
    simulate(system, tmp_path / "run", stop_time=DURATION)
    found = columns(tmp_path / "run")
    assert set(found) == set(map(as_flat, flown))
    for name, values in flown.items():
        np.testing.assert_array_equal(found[as_flat(name)], values, name)


def test_metadata_of_a_package_name_its_fmus(delivered):
    manifest = json.loads((delivered / MANIFEST).read_text())["configurations"]["distributed"]
    package = delivered / "distributed" / "native" / "closed" / "slew.ssp"
    with SRMD(package.with_suffix(".srmd")) as metadata:
        assert metadata.checksum == hashlib.sha3_256(package.read_bytes()).hexdigest()
        entries = {e.keyword: e.text for c in metadata.classifications for e in c.classification_entries}
    with zipfile.ZipFile(package) as archive:
        for component in ("plant", "sensors", "controller"):
            facts = manifest["fmus"][f"distributed/native/{component}.fmu"]
            inside = hashlib.sha256(archive.read(f"resources/{component}.fmu")).hexdigest()
            assert entries[f"{component}.sha256"] == facts["sha256"] == inside
    assert "distributed/native/closed/slew.srmd" in manifest["files"]


FAULTS = """
[[fault]]
name = "star tracker outage"
connection = ["controller.star_tracker.mrp", "controller.star_tracker.valid"]
kind = "dropout"
from = 0.0
to = 0.2

[[fault]]
name = "gyro"
connection = "controller.gyro.rate[1]"
kind = "noise"
deviation = 1e-7
seed = 5
from = 0.05

[[fault]]
name = "bearing"
parameter = "plant.wheel.friction_torque[1]"
kind = "stuck"
value = 0.01
from = 0.1
"""
ALL_OF_IT = (
    *("--stop-time", "0.3", "--seed", "4", "--delay", "sensors:controller=3"),
    *("--set", "plant.dispersion.frequency=0.03", "--set", "plant.dispersion.damping=0.5"),
    *("--set", "plant.dispersion.inertia=0.02,0.004,0.03", "--set", "controller.delay.measurement=0.003"),
    *("--set", "sensors.gyro.noise=3e-7", "--record", "outputs:plant.*", "--record", "controller.wheel.torque"),
)


def test_faults_dispersions_delays_and_a_checkpoint_act_as_in_python(delivered, tmp_path, capsys):
    faults = tmp_path / "faults.toml"
    faults.write_text(FAULTS, encoding="utf-8")
    command = ["run", str(delivered / "centralised" / "fine_pointing.ssd"), "--faults", str(faults), *ALL_OF_IT]
    for kind, options in {"python": (), "native": ("--native", "--checkpoint", "0.15")}.items():
        assert main([*command, *options, "--out", str(tmp_path / kind)]) == 0, capsys.readouterr().err
    differences = {found.port: found.relative for found in compare_folders(tmp_path / "native", tmp_path / "python")}
    conserved = ("plant.velocity", "plant.angular_momentum")  # rounding alone, as nothing acts from outside
    assert {port: value for port, value in differences.items() if not value < SAME and port not in conserved} == {}
    assert any(value > 0.0 for port, value in differences.items() if port not in conserved)

    checkpoint = str(tmp_path / "native" / "checkpoints" / "t=0.15.ckpt")
    rest = ["run", "--restart-from", checkpoint, "--faults", str(faults), "--out", str(tmp_path / "rest")]
    assert main(rest) == 0, capsys.readouterr().err
    parts = ("sensors", "controller", "plant")
    sources = [str(delivered / "centralised" / "native" / f"{part}.fmu") for part in parts]
    assert [c["source"] for c in read_run_record(tmp_path / "rest")[0]["component"]] == sources
    whole, rest_of = columns(tmp_path / "native"), columns(tmp_path / "rest")
    for name, values in rest_of.items():
        np.testing.assert_array_equal(values, whole[name][-len(values) :], name)


def test_a_checkpoint_of_the_others_is_refused_by_name(delivered, tmp_path, capsys):
    system = str(delivered / "centralised" / "fine_pointing.ssd")
    options = ["--stop-time", "0.02", "--checkpoint", "0.01", "--native", "--out", str(tmp_path / "native")]
    assert main(["run", system, *options]) == 0
    checkpoint = str(tmp_path / "native" / "checkpoints" / "t=0.01.ckpt")
    capsys.readouterr()
    assert main(["run", system, "--restart-from", checkpoint, "--out", str(tmp_path / "other")]) == 2
    error = capsys.readouterr().err
    assert error.startswith("flexsat: sensors: t=0.01.ckpt was made with another FMU, ")
    assert error.endswith("; give the same, or --reinitialise sensors\n")


def test_replacement_shadow_and_mixed_systems(delivered, tmp_path, capsys):
    layout = delivered / "centralised"
    system, controller = str(layout / "fine_pointing.ssd"), layout / "controller.fmu"
    native_controller = layout / "native" / "controller.fmu"
    common = ["--stop-time", "0.1"]
    runs = {
        "replaced": ["--native", "--replace", f"controller={controller}"],
        "shadow": ["--shadow", f"controller={native_controller}"],
    }
    for name, options in runs.items():
        assert main(["run", system, *common, *options, "--out", str(tmp_path / name)]) == 0, capsys.readouterr().err
    sources = {c["name"]: c["source"] for c in read_run_record(tmp_path / "replaced")[0]["component"]}
    assert sources["controller"] == str(controller)
    assert sources["plant"] == str(layout / "native" / "plant.fmu")

    mixed = tmp_path / "mixed.ssd"  # the same, as a system file declares it
    write_ssd(load_system(system), mixed)
    text = mixed.read_text(encoding="utf-8")
    for timing in ('offset="0" kind="continuous"', 'period="0.001" offset="0" kind="sampled"'):  # plant, sensors
        text = text.replace(timing, f'native="true" {timing}')
    mixed.write_text(text, encoding="utf-8")
    assert main(["run", str(mixed), *common, "--out", str(tmp_path / "mixed")]) == 0, capsys.readouterr().err
    for found in compare_folders(tmp_path / "mixed", tmp_path / "replaced"):
        assert found.relative == 0.0, found

    shadow = read_signals(tmp_path / "shadow")
    residual = shadow["controller.residual.wheel.torque"]
    assert 0.0 < np.abs(residual).max() < SAME * np.abs(shadow["controller.wheel.torque"]).max()


def test_a_system_of_which_some_fmus_have_no_native_one_says_so(delivered, tmp_path, capsys):
    for file in ("fine_pointing.ssd", *(f"{part}.fmu" for part in ("plant", "sensors", "controller"))):
        shutil.copy(delivered / "centralised" / file, tmp_path)
    (tmp_path / "native").mkdir()
    shutil.copy(delivered / "centralised" / "native" / "plant.fmu", tmp_path / "native")
    command = ["run", str(tmp_path / "fine_pointing.ssd"), "--native", "--stop-time", "0.01"]
    assert main([*command, "--out", str(tmp_path / "run")]) == 0
    assert capsys.readouterr().out.startswith("FMUs: native (plant), Python (sensors, controller)\n")


def test_equivalence_of_native_fmus_and_the_python_steppers(delivered, tmp_path, capsys, monkeypatch):
    command = ["equivalence", "--native", "--configuration", "centralised", "--scenario", "fine_pointing"]
    command += ["--stop-time", "0.1", "--record", "outputs:*", "--fmus", str(delivered), "--out", str(tmp_path)]
    assert main(command) == 0
    begin = "centralised fine_pointing, native, 0.1 s, seed 1: 686 signals, largest difference "
    printed = capsys.readouterr().out
    assert printed.startswith(begin)
    assert 0.0 < float(printed.removeprefix(begin).split()[0]) < SAME

    monkeypatch.setattr("flexbench.loop.equivalence.NATIVE_TOLERANCE", 1e-18)  # the gate closes
    assert main([*command, "--json", str(tmp_path / "ports.json")]) == 1
    rows = json.loads((tmp_path / "ports.json").read_text())["tables"][0]["rows"]
    assert sum(signals for _, _, _, signals, *_ in rows) == 686
    assert f"{max(relative for *_, relative, _, _ in rows):.1e}" == printed.removeprefix(begin).split()[0]
    assert {agrees for *_, agrees in rows} == {True, False}
    assert capsys.readouterr().err.endswith("flexsat: signals differ by more than 1e-18\n")
