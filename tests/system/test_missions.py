"""Missions through their FMUs: momentum and impulse, pointing, modes, failures; both kinds of FMUs."""

import hashlib
import json
import zipfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.loop.native_fmus import with_native_fmus
from flexsat.design.chain import build_designs
from flexsat.fmu import build_missions
from flexsat.parameters import ARCSECOND
from flexsat.runtime.rotations import error_angle, matrix_from_mrp
from lockstep import Signals, load_system, read_signals, simulate

ROOT = Path(__file__).parents[2]
DATA = ROOT / "examples" / "missions"
STEP = 5e-3  # s, of thrusters and controller
OFF_LOAD = """
[[command]]
at = 5.0
do = "off-load"
[set]
"plant.initial.wheel.speed_offset" = [0.4, 0.2, 0.0, -0.4, -0.2, 0.1]
"mission.off_loading.duration" = 30.0
"""
SEIZED = """
[[fault]]
name = "wheel 1 seizes slowly"
parameter = "plant.wheel.friction_torque[1]"
kind = "stuck"
value = 3.0
from = 10.0
"""
LOST = """
[[fault]]
name = "torque of wheel 1 lost"
connection = "plant.wheel.torque[1]"
kind = "scale"
factor = 0.0
from = 20.0
"""


@pytest.fixture(scope="session")
def layout(missions: Callable[[str], Path]) -> Path:
    """Return the folder of missions of the centralised layout."""
    return missions("centralised")


@pytest.fixture
def fly(layout: Path, fly_from: Callable[..., Signals]) -> Callable[..., Signals]:
    """Return what runs a system of the centralised layout, and returns its signals."""
    return partial(fly_from, layout)


def pointing(run: Signals, after: float = 0.0) -> float:
    """Return the greatest pointing error [arcsec] from a time on."""
    error = error_angle(run["plant.attitude.mrp"], run["controller.reference.mrp"]) / ARCSECOND
    return float(error[run.time >= after].max())


def events(folder: Path, kind: str) -> list[dict[str, object]]:
    lines = [json.loads(line) for line in (folder / "events.jsonl").read_text(encoding="utf-8").splitlines()]
    return [line for line in lines if line["event"] == kind]


def test_the_manifest_lists_what_is_in_the_folder_with_its_hash(layout: Path):
    top = layout.parents[1]
    entry = json.loads((top / "manifest.json").read_text(encoding="utf-8"))["configurations"]["centralised"]
    listed = {name: facts["sha256"] for name, facts in {**entry["fmus"], **entry["files"]}.items()}
    found = {path.relative_to(top).as_posix(): path for path in layout.rglob("*") if path.is_file()}

    assert listed == {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in found.items()}
    assert {facts["component"] for facts in entry["fmus"].values()} == {
        name + kind for name in ("environment", "thrusters", "mission") for kind in ("", ", native")}  # fmt: skip
    document = (layout / "ICD.md").read_text(encoding="utf-8")
    assert all(name in document and facts["guid"] in document for name, facts in entry["fmus"].items())


def test_thrusters_of_fmi_3_built_for_a_platform_give_the_bits_of_fmi_2(
    layout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(build_missions, "MISSION_SHELLS", {"thrusters": build_missions.MISSION_SHELLS["thrusters"]})
    built = build_missions.build_missions(
        build_designs("centralised"), tmp_path, versions_in_c=("3.0",), platforms=("linux64",)
    )
    fmu = tmp_path / "centralised" / "missions" / "native" / "fmi3" / "thrusters.fmu"
    assert built["thrusters, FMI 3.0"].path == fmu
    with zipfile.ZipFile(fmu) as archive:
        assert '"zig ' in archive.read("resources/build.json").decode()
        assert b'fmiVersion="3.0"' in archive.read("modelDescription.xml")

    system = with_native_fmus(load_system(layout / "mission.ssd"))
    found = []
    for name, source in (("two", None), ("three", fmu)):
        components = tuple(replace(c, source=source) if source and c.name == "thrusters" else c
                           for c in system.components)  # fmt: skip
        simulate(replace(system, components=components), tmp_path / name, stop_time=0.3, record=["thrusters.*"],
                 overrides={"mission.timeline.action[1]": 2, "mission.settle.dwell": 0.0,
                            "plant.initial.wheel.speed_offset[1]": 0.4})  # fmt: skip
        found.append(read_signals(tmp_path / name))
    assert found[0]["thrusters.thrust.impulse"][-1] > 0.0
    for name in ("thrust", "external.torque", "thrust.impulse"):
        assert np.array_equal(found[0][f"thrusters.{name}"], found[1][f"thrusters.{name}"])


def test_off_loading_removes_the_momentum_of_the_external_impulse_while_pointing_holds(
    fly: Callable[..., Signals], tmp_path: Path
):
    # the wheels' imbalance acts as from outside on the plant: it is left out
    run = fly(60.0, "--record", "plant.attitude.mrp", "--record", "plant.angular_momentum", "--record", "mission.*",
              "--record", "thrusters.external.torque", "--record", "controller.reference.mrp", "--set",
              "sensors.jitter.enabled=false", mission=OFF_LOAD)  # fmt: skip
    torque = np.array([matrix_from_mrp(p).T @ t for p, t in zip(run["plant.attitude.mrp"],
                       run["thrusters.external.torque"], strict=True)])  # fmt: skip
    impulse = STEP * torque[:-1].sum(axis=0)
    removed = run["plant.angular_momentum"][-1] - run["plant.angular_momentum"][0]

    assert np.abs(removed).max() > 3.0  # N.m.s
    assert_allclose(removed, impulse, atol=1e-9 * np.abs(removed).max())  # 4e-11: to rounding, and the plant's own
    assert np.abs(run["mission.momentum"][-1]).max() < 0.02 + 0.02  # the tolerance, and what the environment adds
    assert [(e["from"], e["to"]) for e in events(tmp_path / "run", "mode")] == [
        ("settle", "fine"), ("fine", "off-load"), ("off-load", "settle"), ("settle", "fine")]  # fmt: skip
    # .15 arcsec without; noise of the pulses of 2 % and their ripple leave .2; without the wheels' answer it is 17
    assert pointing(run) < 0.4
    without = fly(50.0, "--set", "mission.off_loading.feed_forward=0.0", "--record-period", "0.1", mission=OFF_LOAD,
                  name="without")  # fmt: skip
    assert pointing(without) > 10.0


def test_a_wheel_that_seizes_is_found_and_the_others_take_its_momentum(fly: Callable[..., Signals], tmp_path: Path):
    run = fly(60.0, "--record-period", "0.1", faults=SEIZED)

    (found,) = events(tmp_path / "run", "wheel-status")
    assert (found["wheel"], found["from"], found["to"]) == (1, "works", "off")
    assert 10.0 < float(str(found["time"])) <= 10.2
    # 150 N.m.s have left the wheel, and gone to the opposite one: 7 arcsec, against 1800 without the manager
    lost = 4.62 * (run["plant.wheel.speed"][-1] - run["plant.wheel.speed"][0])
    assert lost[0] < -140.0
    assert_allclose(lost[3], lost[0], rtol=0.01)  # about the opposite axis: the sum of both stays
    assert pointing(run) < 10.0


def test_a_torque_lost_in_a_slew_is_found_and_given_to_the_others(fly: Callable[..., Signals], tmp_path: Path):
    slew = '[[command]]\nat = 6.0\ndo = "slew"\nrotation = [60.0, 0.0, 0.0]\nunit = "arcsec"\n'
    run = fly(70.0, "--record-period", "0.1", mission=slew, faults=LOST)

    (found,) = events(tmp_path / "run", "wheel-status")
    assert (found["wheel"], found["to"]) == (1, "off")
    assert 20.0 < float(str(found["time"])) < 21.0
    assert pointing(run) < 1.0
    turned = 4.0 * run["plant.attitude.mrp"][-1] / ARCSECOND
    assert_allclose(turned, [60.0, 0.0, 0.0], atol=1.0)
    assert run["mission.mode"][-1] == 3  # fine


def test_both_kinds_of_fmus_fly_the_same_mission(fly: Callable[..., Signals]):
    words = ("--record", "mission.*", "--record", "thrusters.*", "--record", "environment.*", "--set",
             "mission.settle.dwell=0.1")  # fmt: skip
    mission = OFF_LOAD.replace("at = 5.0", "at = 0.3")
    native = fly(1.5, *words, mission=mission, name="native")
    python = fly(1.5, *words, mission=mission, name="python", native=False)

    assert native["thrusters.thrust.impulse"][-1] > 0.0
    for name in native.columns:
        scale = max(1.0, float(np.abs(native[name]).max()))
        assert_allclose(native[name], python[name], rtol=0.0, atol=1e-10 * scale, err_msg=name)


def test_an_environment_alone_disturbs_the_loop(fly: Callable[..., Signals]):
    run = fly(2.0, "--set", "environment.constant.torque[1]=0.01", "--set", "sensors.jitter.enabled=false",
              "--record", "environment.external.torque", "--record", "plant.angular_momentum",
              system="environment")  # fmt: skip
    gained = run["plant.angular_momentum"][-1] - run["plant.angular_momentum"][0]

    assert_allclose(gained, 2.0 * run["environment.external.torque"][0], rtol=1e-3)  # it hardly changes in 2 s
    assert gained[0] > 0.019


def test_the_short_day(fly: Callable[..., Signals], tmp_path: Path):
    run = fly(130.0, "--record-period", "0.1", mission=(DATA / "short_day.toml").read_text(encoding="utf-8"))

    assert [e["to"] for e in events(tmp_path / "run", "mode")] == [
        "fine", "off-load", "settle", "fine", "slew", "settle", "fine"]  # fmt: skip
    assert pointing(run) < 0.5
