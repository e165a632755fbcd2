"""One BLAS thread a process, before numpy is imported: the tests run side by side, and the matrices are small.

Also the FMUs that several folders of tests use: those of flexsat, and those in C.
"""

import gc
import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import threading
import weakref
from collections.abc import Callable, Generator
from pathlib import Path
from types import ModuleType
from typing import Any

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import pytest  # noqa: E402
from filelock import FileLock  # noqa: E402

if threading.current_thread() is threading.main_thread():
    # where signals are ignored, as in a background job of a shell or under nohup, all that is started would ignore them
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)

import fmus.c_fmu  # noqa: E402
import fmus.reference.build  # noqa: E402

_FLEXSAT = Path(sys.executable).with_name("flexsat")
_TESTS = Path(__file__).parent


Make = Callable[[Path], None]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add what executes the ticks of runs in the processes of the tests."""
    parser.addoption("--tick", choices=("python", "c"), help="what executes ticks where a test leaves it open")


@pytest.fixture(scope="session", autouse=True)
def _given_tick(request: pytest.FixtureRequest) -> Generator[None, None, None]:
    """Execute ticks in C or in Python, as the option says; runs in processes of their own choose by themselves."""
    given = request.config.getoption("--tick")
    with pytest.MonkeyPatch.context() as patch:
        if given is not None:
            from lockstep.run.choose_tick import choose_tick
            from lockstep.simulation import open_run

            def choose(wanted: str, *times: Any) -> Any:
                return choose_tick(given if wanted == "auto" else wanted, *times)

            patch.setattr(open_run, "choose_tick", choose)
        yield


gc.disable()  # while the tests are collected: nothing that comes then goes again


def pytest_collection_finish() -> None:
    """Look for garbage again, but not among modules and tests, which stay to the end."""
    gc.enable()
    gc.freeze()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Order files so that no worker waits for another and all end together.

    The study comes first, which builds the FMUs and then simulates. Meanwhile the others take tests of the spacecraft,
    which need no built FMUs; then files with long co-simulations, pages whose commands run as written, files that
    simulate the delivered systems, and last the many that are quick. A file of minutes at the end has one core alone.
    """
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    waiting = {item.path for item in items if "delivered" in getattr(item, "fixturenames", ())}

    def place(path: Path) -> int:
        folders = set(path.relative_to(_TESTS).parts)
        if path.name == "test_paper.py":
            return 0
        if "flexsat" in folders and path not in waiting:
            return 1
        if path in slow or {"tutorials", "examples"} & folders or path.name == "test_docs_build.py":
            return 2
        return 3 if {"hosts", "system"} & folders else 4

    items.sort(key=lambda item: place(item.path))


def _shared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the session's folder, above those of the workers."""
    base = tmp_path_factory.getbasetemp()
    return base.parent if "PYTEST_XDIST_WORKER" in os.environ else base


@pytest.fixture(scope="session", autouse=True)
def _kept_libraries(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Compile each library of a test FMU once for all workers."""
    fmus.c_fmu.kept = _shared(tmp_path_factory) / "libraries"


@pytest.fixture(scope="session", autouse=True)
def _kept_objects(tmp_path_factory: pytest.TempPathFactory) -> Generator[None, None, None]:
    """Compile each unit of the FMUs in C once for all workers, and for the commands that they start."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FLEXSAT_OBJECTS", str(_shared(tmp_path_factory) / "objects"))
        yield


@pytest.fixture(scope="session")
def once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Make], Path]:
    """Return a function that makes a named folder once for all workers, whichever comes first; for reading only."""
    shared = _shared(tmp_path_factory)

    def made(name: str, make: Make) -> Path:
        folder, result = shared / name, shared / f"{name}.made"
        with FileLock(shared / f"{name}.lock"):
            if not result.exists():
                try:
                    make(folder)
                except BaseException as error:
                    result.write_text(f"{type(error).__name__}: {error}", encoding="utf-8")
                    raise
                result.touch()
        failure = result.read_text(encoding="utf-8")
        assert not failure, f"{name} could not be made: {failure}"
        return folder

    return made


@pytest.fixture(scope="session")
def delivered(once: Callable[[str, Make], Path]) -> Path:
    """Return what `flexsat build --flat` leaves, for reading only."""

    def build(folder: Path) -> None:
        subprocess.run([_FLEXSAT, "build", "--flat", "--out", folder], check=True, capture_output=True)

    return once("delivered", build)


def _load(name: str, path: Path) -> Any:
    """Load a module of the tests from its file."""
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def reference() -> ModuleType:
    """Return the module that knows the FMUs of tests/fmus/reference."""
    return fmus.reference.build


@pytest.fixture(scope="session")
def require_master() -> Callable[[str], None]:
    """Return a function that skips where a foreign master, `ecos` or `libcosim`, cannot run, and says why."""
    availability = _load("availability_of_hosts", _TESTS / "hosts" / "availability.py")

    def require(name: str) -> None:
        lacks = getattr(availability, f"{name}_lacks")()
        if lacks:
            pytest.skip(lacks)

    return require


@pytest.fixture(scope="session")
def reference_fmu(tmp_path_factory: pytest.TempPathFactory, reference: ModuleType) -> Callable[[str, str], Path]:
    """Return a function that compiles a reference FMU once: by model (`integrator`, ...) and version (`3.0`)."""
    if shutil.which("gcc") is None:
        pytest.skip("the reference FMUs are compiled with gcc")
    folder = tmp_path_factory.mktemp("reference")

    def built(model: str, version: str) -> Path:
        path = folder / version / model / f"{model}.fmu"
        return path if path.exists() else reference.build(model, version, path.parent)

    return built


_started: "weakref.WeakSet[subprocess.Popen[Any]]" = weakref.WeakSet()
_popen = subprocess.Popen.__init__


def _recorded_popen(self: "subprocess.Popen[Any]", *arguments: Any, **options: Any) -> None:
    _started.add(self)
    _popen(self, *arguments, **options)


subprocess.Popen.__init__ = _recorded_popen  # type: ignore[method-assign]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Generator[None, object, object]:
    """End the processes that a failed test leaves: their ResourceWarnings would fail a later test in its setup."""
    before = set(_started)
    try:
        return (yield)
    except BaseException:
        for process in set(_started) - before:
            if hasattr(process, "returncode") and process.poll() is None:
                process.kill()
                process.communicate()
        raise
