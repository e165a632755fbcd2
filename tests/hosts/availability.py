"""What each foreign host needs and this machine lacks: one line with the remedy, or nothing."""

from __future__ import annotations

import ctypes
import ctypes.util
import importlib.util
import shutil
import sys
import sysconfig
from pathlib import Path

HOSTS_PYTHON = Path(__file__).parents[2] / ".venv-hosts" / "bin" / "python"


def ecos_lacks() -> str:
    """Return what ecos lacks here, or nothing."""
    if importlib.util.find_spec("ecospy") is None:
        return "ecos needs the Python package ecospy: pip install ecospy"
    if ctypes.util.find_library("tbb") is None and not _loads("libtbb.so.12"):
        return "ecos needs the library TBB: apt-get install libtbb12"
    return ""


def libcosim_lacks() -> str:
    """Return what libcosim lacks here, or nothing."""
    return "" if importlib.util.find_spec("libcosimpy") else "libcosim needs libcosimpy: pip install libcosimpy"


def lacks(module: str, package: str) -> str:
    """Return what is missing of a package of the tests' own environment, or nothing."""
    return "" if importlib.util.find_spec(module) else f"{package} is not installed: pip install --group dev"


def hosts_python_lacks() -> str:
    """Return what is missing of the environment of hosts that need other versions than flexsat, or nothing."""
    installed = HOSTS_PYTHON.parents[1] / "installed"  # left by the Makefile after the last package
    return "" if installed.is_file() else "needs an environment of its own: make .venv-hosts/installed"


def c_host_lacks() -> str:
    """Return what the C host lacks here, or nothing."""
    if shutil.which("gcc") is None:
        return "a C compiler is needed: apt-get install gcc libc6-dev"
    if not libpython():
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        return f"this Python has no shared library to lend to a C program: apt-get install libpython{version}"
    return ""


def libpython() -> str:
    """Return the path of this Python's shared library, or nothing."""
    name, folder = sysconfig.get_config_var("INSTSONAME"), Path(sysconfig.get_config_var("LIBDIR"))
    candidates = (folder / name, folder / (sysconfig.get_config_var("MULTIARCH") or "") / name)
    return next((str(path) for path in candidates if ".so" in name and path.is_file()), "")


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
