"""Isolated FMUs beside each other, the end of their master, and which FMUs are isolated."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest

from fmus.bad.bad_fmus import GUID, XML, bad_fmu
from lockstep import Component, InputError, System, load_system, read_signals
from lockstep.fmi.model_description import read_description
from lockstep.fmi.temporary_folder import remove_abandoned, temporary_folder
from lockstep.processes.isolation_policy import settle


@pytest.fixture(scope="module")
def waiting(tmp_path_factory):
    """Return an FMU whose every step ends only when an instance `a` and one `b` have both begun it."""
    return bad_fmu(tmp_path_factory.mktemp("waiting"), "WAITS_FOR_THE_OTHER")


def test_steps_overlap_where_no_connection_orders_them(runs, pair, waiting, tmp_path):
    later, now = tmp_path / "later", tmp_path / "now"
    ended = runs(
        {
            "later": (later, ("run", pair(later, waiting, waiting, delay=1), "--out", later / "out")),
            "now": (now, ("run", pair(now, waiting, waiting), "--out", now / "out", "--step-limit", "2")),
        }
    )
    assert (ended["later"]["code"], ended["later"]["lines"]) == (0, [])  # one after the other would wait for ever
    assert ended["now"]["lines"] == ["lockstep: a: no answer within 2 s in fmi2DoStep at 0 s"]  # b needs its output


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_values_equal_those_of_a_run_in_one_process(runs, pair, good, tmp_path, delay):
    system = pair(tmp_path, good, good, delay=delay)
    cases = {
        name: (tmp_path / name, ("run", system, "--out", tmp_path / name / "out", *options))
        for name, options in {
            "isolated": (),
            "mixed": ("--share-process", "a"),
            "shared": ("--share-process", "a", "--share-process", "b"),
        }.items()
    }
    assert [ended["code"] for ended in runs(cases).values()] == [0, 0, 0]
    one, two, three = (read_signals(tmp_path / name / "out") for name in cases)
    assert list(one.columns) == ["a.scaled", "a.filtered", "a.count", "b.scaled", "b.filtered", "b.count"]
    for name in one.columns:
        np.testing.assert_array_equal(one[name], three[name])
        np.testing.assert_array_equal(two[name], three[name])


@pytest.fixture(scope="module")
def hanging(tmp_path_factory):
    """Return an FMU whose sixth step never ends."""
    return bad_fmu(tmp_path_factory.mktemp("hanging"), "HANGS")


def workers(place):
    """Return the processes with a temporary folder below this one in their environment."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if f"TMPDIR={place}/lockstep-".encode() in (folder / "environ").read_bytes():
                found.append(int(folder.name))
        except OSError:  # ended meanwhile
            continue
    return found


def start(system, tmp_path, rows=250):
    """Start a run without end and wait until it has recorded so many rows."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    command = [
        sys.executable,
        "-m",
        "lockstep",
        "run",
        str(system),
        "--out",
        str(tmp_path / "out"),
        "--stop-time",
        "1e6",
    ]
    process = subprocess.Popen(
        command,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "TMPDIR": str(temporary), "DIARY": str(tmp_path / "diary")},
    )
    stream = tmp_path / "out" / "signals.arrows"
    deadline = time.monotonic() + 60.0
    while not stream.exists() or stream.stat().st_size < 8 * 7 * rows:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert len(workers(temporary)) == 4  # each with its guard
    return process, temporary


def assert_no_workers(place):
    deadline = time.monotonic() + 30.0
    while workers(place):
        assert time.monotonic() < deadline, "a worker outlives its master"
        time.sleep(0.02)


def test_ctrl_c_ends_the_workers_and_frees_their_fmus(pair, good, tmp_path):
    process, temporary = start(pair(tmp_path, good, good), tmp_path)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, error = process.communicate(timeout=60)

    assert (process.returncode, error.splitlines()[-1]) == (130, "lockstep: interrupted")
    assert (workers(temporary), list(temporary.iterdir())) == ([], [])
    assert (tmp_path / "diary").read_text() == "b terminated\nb freed\na terminated\na freed\n"


def test_the_workers_of_a_killed_master_end_and_its_folder_is_removed_by_a_later_run(pair, good, tmp_path):
    process, temporary = start(pair(tmp_path, good, good), tmp_path)
    (folder,) = temporary.iterdir()
    os.utime(folder / ".lock", (0.0, 0.0))
    remove_abandoned(temporary)
    assert folder.exists()  # the run goes on
    process.kill()
    process.communicate(timeout=60)
    assert_no_workers(temporary)
    remove_abandoned(temporary)
    assert list(temporary.iterdir()) == []


def test_a_hanging_worker_ends_with_its_master(pair, good, hanging, tmp_path):
    process, temporary = start(pair(tmp_path, good, hanging), tmp_path, rows=0)
    time.sleep(0.5)  # for its five steps
    process.kill()
    process.communicate(timeout=60)
    assert_no_workers(temporary)


@pytest.mark.parametrize("times", [1, 2])
def test_ctrl_c_ends_a_hanging_step(pair, good, hanging, tmp_path, times):
    process, temporary = start(pair(tmp_path, good, hanging), tmp_path, rows=0)
    time.sleep(0.5)  # for its five steps
    process.send_signal(signal.SIGINT)
    if times > 1:
        time.sleep(1.1)  # within a second that is one, as a terminal may send it twice
        process.send_signal(signal.SIGINT)  # by then the files are being closed
    _, error = process.communicate(timeout=30)  # half of the step limit

    assert (process.returncode, error.splitlines()[-1]) == (130, "lockstep: interrupted")
    assert (workers(temporary), list(temporary.iterdir())) == ([], [])
    assert (tmp_path / "diary").read_text() == "a terminated\na freed\n"
    record = tomllib.loads((tmp_path / "out" / "run.toml").read_text())
    assert (record["status"], record["simulated_time"]) == ("interrupted", 0.05)
    assert read_signals(tmp_path / "out")["b.count"].tolist() == [1, 2, 3, 4, 5]


def test_a_young_folder_is_not_removed(tmp_path):
    folder = tmp_path / "lockstep-run-1-x"
    folder.mkdir()
    (folder / ".lock").touch()  # its maker has not locked it yet
    remove_abandoned(tmp_path)
    assert folder.exists()


def test_a_folder_whose_process_lives_is_not_removed_though_its_lock_is_unseen(tmp_path):
    lock = tmp_path / "lockstep-run-1-x" / ".lock"
    lock.parent.mkdir()
    lock.write_text(f"{os.getpid()}\n")  # as where `fcntl` is missing
    remove_abandoned(tmp_path)
    assert lock.exists()
    os.utime(lock, (0.0, 0.0))  # written before this process began: by another one of that number
    remove_abandoned(tmp_path)
    assert not lock.exists()


def test_a_folder_without_a_lock_is_removed_once_its_process_has_ended(tmp_path):
    """Killed before it locked its folder, or while it removed it; other folders stay."""
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    mine, gone, young, foreign = (
        tmp_path / name
        for name in (f"lockstep-run-{os.getpid()}-x", f"lockstep-check-{ended.pid}-x", f"lockstep-run-{ended.pid}-y",
                     "lockstep-ssp-x")
    )  # fmt: skip
    for folder in (mine, gone, young, foreign):
        (folder / "unpacked").mkdir(parents=True)
    for folder in (gone, foreign):
        os.utime(folder, (time.time() - 2.0, time.time() - 2.0))
    assert remove_abandoned(tmp_path) == [gone]
    assert all(folder.exists() for folder in (mine, young, foreign))


@pytest.mark.parametrize("purpose", ["run", "check", "latency", "adapt"])
def test_every_temporary_folder_is_locked_and_names_its_process(purpose, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with temporary_folder(purpose) as folder:
        assert folder.name.startswith(f"lockstep-{purpose}-{os.getpid()}-")
        assert remove_abandoned(tmp_path) == []
        assert (folder / ".lock").read_text() == f"{os.getpid()}\n"
    assert not folder.exists()


@pytest.fixture
def fmu(tmp_path):
    """Return a function that makes an FMU with some files, as far as a master reads it before it starts any."""

    def make(name, once=False, **files):
        flag = f'canBeInstantiatedOnlyOncePerProcess="{str(once).lower()}"'
        with zipfile.ZipFile(tmp_path / f"{name}.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", XML.replace("canNotUse", f"{flag} canNotUse"))
            archive.writestr("binaries/linux64/bad.so", "")
            for path, content in files.items():
                archive.writestr(path.replace("__", "/").replace("_dot_", "."), content)
        return tmp_path / f"{name}.fmu"

    return make


BUILT_HERE = {"resources__build_dot_json": json.dumps({"guid": GUID})}


def isolated(**sources):
    """Return what is decided for components: by FMU, or by FMU and the setting in the system."""
    pairs = {name: given if isinstance(given, tuple) else (given, None) for name, given in sources.items()}
    parts = tuple(Component(name=n, source=s, period=1, isolated=given) for n, (s, given) in pairs.items())
    settled = settle(System(name="s", tick=1, components=parts), {c.name: read_description(c) for c in parts})
    return [component.isolated for component in settled.components]


def test_foreign_fmus_are_isolated_by_default(fmu):
    built, other = fmu("built", **BUILT_HERE), fmu("other")
    stolen = fmu("stolen", resources__build_dot_json=json.dumps({"guid": "{of another}"}))
    odd = fmu("odd", resources__build_dot_json="[1]")
    assert isolated(a=built, b=other, c=stolen, d=odd) == [False, True, True, True]
    assert isolated(a=(built, True), b=(other, False)) == [True, False]


def test_one_process_holds_one_copy_of_a_module(fmu):
    one = fmu("one", **BUILT_HERE, resources__law__gains_dot_py="k = 1")
    same = fmu("same", **BUILT_HERE, resources__law__gains_dot_py="k = 1", resources__data_dot_txt="x")
    other = fmu("other", **BUILT_HERE, resources__law__gains_dot_py="k = 2")
    assert isolated(a=one, b=same) == [False, False]
    assert isolated(a=one, b=other) == [False, True]
    assert isolated(a=one, b=(other, False)) == [True, False]  # that which has to be there comes first
    assert isolated(a=(one, True), b=other) == [True, False]
    with pytest.raises(InputError, match="b: brings another copy of law than a; run one of them in a process"):
        isolated(a=(one, False), b=(other, False))


def test_libraries_in_an_fmu_count_as_modules(fmu):
    one = fmu("one", **BUILT_HERE, binaries__linux64__libhelp_dot_so="1")
    other = fmu("other", **BUILT_HERE, binaries__linux64__libhelp_dot_so="2")
    assert isolated(a=one, b=other) == [False, True]


def test_an_fmu_that_allows_one_instance_gets_a_process_for_the_second(fmu):
    once = fmu("once", once=True, **BUILT_HERE)
    assert isolated(a=once, b=once) == [False, True]
    with pytest.raises(InputError, match="b: the FMU allows one instance per process, and a is it already"):
        isolated(a=(once, False), b=(once, False))


def test_the_system_file_decides(pair, good, tmp_path):
    path = pair(tmp_path, good, good, isolated=True)
    assert [component.isolated for component in load_system(path).components] == [True, True]
    path.write_text(path.read_text().replace('isolated="true"', 'isolated="maybe"', 1))
    with pytest.raises(InputError, match="a: isolated 'maybe' must be true or false"):
        load_system(path)


def test_a_step_limit_must_be_a_time(runs, pair, good, tmp_path):
    system, limits = pair(tmp_path, good, good), ("0", "soon", "nan", "-1")
    ended = runs({x: (tmp_path / x, ("run", system, "--out", tmp_path / "out", f"--step-limit={x}")) for x in limits})
    assert {x: (run["code"], run["lines"]) for x, run in ended.items()} == {
        x: (2, [f"lockstep: step limit '{x}' must be a number of seconds > 0, for example 60"]) for x in limits
    }


def test_an_unknown_component_cannot_be_isolated(pair, good, tmp_path):
    with pytest.raises(InputError, match="c: no such component; there are a, b"):
        load_system(pair(tmp_path, good, good)).with_isolation("c", True)
