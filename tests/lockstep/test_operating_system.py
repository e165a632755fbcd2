"""What Linux alone offers is used in one module, and a system is simulated without it."""

import ast
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bare_system import run_without
from lockstep import read_signals, simulate, write_ssd
from lockstep.operating_system import lock_file, lock_folder

ORCHESTRATOR = Path(__file__).parents[2] / "orchestrator"
SEAM = ORCHESTRATOR / "lockstep/operating_system.py"
MODULES = {"fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog", "posix", "_posixshmem"}
NAMES = {
    *("fork", "forkpty", "memfd_create", "sched_getaffinity", "sched_setaffinity", "sched_getscheduler", "sysconf"),
    *("pthread_sigmask", "pidfd_open", "waitpid", "getsid", "setsid", "killpg", "getuid", "SIGKILL", "SIGALRM"),
    *("prctl", "personality", "sched_getcpu", "flock", "lockf", "setrlimit", "getrlimit", "getrusage", "nice"),
}

RUN = """
from lockstep.__main__ import main
sys.exit(main(sys.argv[3:]))
"""


def uses(source):
    """Return what a source uses that only the seam may."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Import():
                found |= {alias.name for alias in node.names} & MODULES
            case ast.ImportFrom(module=module) if module in MODULES:
                found.add(module)
            case ast.ImportFrom(module="os" | "signal"):
                found |= {alias.name for alias in node.names} & NAMES
            case ast.Attribute(attr=name) if name in NAMES:
                found.add(name)
            case ast.Constant(value=str(text)) if text.startswith("/proc"):
                found.add(text)
    return found


def test_only_one_module_uses_what_linux_alone_offers():
    texts = {path: path.read_text(encoding="utf-8") for path in ORCHESTRATOR.rglob("*.py") if path != SEAM}
    words = re.compile(rf"\b({'|'.join(MODULES | NAMES)})\b|/proc")  # other texts need not be parsed
    found = {path.name: uses(text) for path, text in texts.items() if words.search(text)}

    assert {name: names for name, names in found.items() if names} == {}
    assert uses(SEAM.read_text(encoding="utf-8")) >= {"memfd_create", "pthread_sigmask", "prctl", "personality"}
    lines = "import fcntl\nfrom os import fork\nos.sched_setaffinity(0, {1})\nopen(f'/proc/{pid}/stat')"
    assert uses(lines) == {"fcntl", "fork", "sched_setaffinity", "/proc/"}


@pytest.fixture
def second(loop):
    """Return the loop of toys for 1 s, all in the process of the master."""
    return replace(loop, stop_time=1_000_000_000)


def test_a_second_of_a_closed_loop_is_the_same_without_it(second, tmp_path):
    write_ssd(second, tmp_path / "loop.ssd")
    shared = [option for name in ("counter", "echo", "plant") for option in ("--share-process", name)]

    done = run_without(RUN, "run", tmp_path / "loop.ssd", "--out", tmp_path / "without", *shared)

    assert done.returncode == 0, done.stderr
    simulate(second, tmp_path / "with")
    mine, usual = (read_signals(tmp_path / name) for name in ("without", "with"))
    assert len(mine.time) == 1001
    for name in usual.columns:
        np.testing.assert_array_equal(mine[name], usual[name], name)
    assert not list((tmp_path / "without").glob("*.lock"))


def test_an_isolated_fmu_is_refused_without_it(second, tmp_path):
    write_ssd(second, tmp_path / "loop.ssd")

    done = run_without(RUN, "run", tmp_path / "loop.ssd", "--out", tmp_path / "out", "--isolate", "counter")

    assert done.returncode == 2
    expected = "counter: cannot run in a process of its own on this operating system; give --share-process counter"
    assert expected in done.stderr
    assert not (tmp_path / "out").exists()


def test_every_module_is_imported_without_it():
    names = [
        ".".join(path.relative_to(ORCHESTRATOR).with_suffix("").parts)
        for package in ("lockstep", "flexbench")
        for path in sorted((ORCHESTRATOR / package).rglob("*.py"))
    ]
    source = "from importlib import import_module\nfor name in sys.argv[3:]: import_module(name)"

    done = run_without(source, *(name for name in names if not name.endswith("__main__")))

    assert done.returncode == 0, done.stderr


LOCKS = """
from pathlib import Path
from lockstep.operating_system import lock_file, lock_folder
folder = Path(sys.argv[3])
for lock, path in ((lock_file, folder / "events"), (lock_folder, folder)):
    unlock = lock(path)
    print(lock(path) is None)
    unlock()
    lock(path)()
    print(list(map(str, folder.glob("*.lock"))))
"""


def test_files_and_folders_are_locked_without_it(tmp_path):
    done = run_without(LOCKS, tmp_path)

    assert done.stdout.split() == ["True", "[]"] * 2, done.stderr


@pytest.mark.parametrize("lock", [lock_file, lock_folder])
def test_a_lock_ends_with_its_release_or_its_process(tmp_path, lock):
    path = tmp_path / "events" if lock is lock_file else tmp_path
    unlock = lock(path)
    assert lock(path) is None
    unlock()
    source = f"from lockstep.operating_system import {lock.__name__} as lock; from pathlib import Path"
    source += f"; import os; lock(Path({str(path)!r})); os._exit(1)"
    assert subprocess.run([sys.executable, "-c", source], check=False).returncode == 1
    lock(path)()
    assert lock is lock_file or list(path.iterdir()) == []


def test_a_file_that_cannot_be_made_is_an_error(tmp_path):
    with pytest.raises(OSError, match="No such file"):
        lock_file(tmp_path / "nowhere/events")
