"""One BLAS thread a process, before numpy is imported: the tests run side by side, and the matrices are small.

Also the FMUs that several folders of tests use: those of flexsat, and those in C.
"""

import fcntl
import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import pytest  # noqa: E402

_FLEXSAT = Path(sys.executable).with_name("flexsat")
_TESTS = Path(__file__).parent


@pytest.fixture(scope="session")
def delivered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return what `flexsat build --flat` leaves, for reading only: built once for all workers."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base  # of the session, above that of a worker
    folder, built = shared / "delivered", shared / "delivered.done"
    with (shared / "delivered.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not built.exists():
            subprocess.run([_FLEXSAT, "build", "--flat", "--out", folder], check=True, capture_output=True)
            built.touch()
    return folder


def _load(name: str, path: Path) -> Any:
    """Load a module of the tests from its file."""
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def reference() -> Any:
    """Return the module that knows the FMUs of tests/fmus/reference."""
    return _load("reference_fmus", _TESTS / "fmus" / "reference" / "build.py")


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
def reference_fmu(tmp_path_factory: pytest.TempPathFactory, reference: Any) -> Callable[[str, str], Path]:
    """Return a function that compiles a reference FMU once: by model (`integrator`, ...) and version (`3.0`)."""
    if shutil.which("gcc") is None:
        pytest.skip("the reference FMUs are compiled with gcc")
    folder = tmp_path_factory.mktemp("reference")

    def built(model: str, version: str) -> Path:
        path = folder / version / model / f"{model}.fmu"
        return path if path.exists() else reference.build(model, version, path.parent)

    return built
