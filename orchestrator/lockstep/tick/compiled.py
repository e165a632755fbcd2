"""Find the library of the tick in C, or compile it: once for each source, compiler and kind of machine.

A wheel may bring the library beside this file. Else it is compiled by the first run into the user's folder of caches,
or for this process alone where that cannot be written.
"""

from __future__ import annotations

import atexit
import ctypes
import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from time import perf_counter

from lockstep.operating_system import only_this_user_writes
from lockstep.tick.structures import LAYOUT, TickOperation, TickState

FOLDER = Path(__file__).parent
SOURCES = tuple(FOLDER / "c" / name for name in ("tick.c", "alter.c", "threads.c", "requests.c"))
HEADERS = tuple(FOLDER / "c" / name for name in ("tick.h", "alter.h", "threads.h", "requests.h", "clock.h", "pace.h"))
OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-pthread", "-fvisibility=hidden")
COMPILERS = ("cc", "gcc", "clang")
_ENDINGS = {"win32": "dll", "darwin": "dylib"}
_LONGEST = 120  # [s] that a compiler may take


class NoLibrary(Exception):
    """The tick in C cannot be had; the text says why."""


def load() -> ctypes.CDLL:
    """Return the library, or raise NoLibrary. The answer of the first call stays."""
    found = _load()
    if isinstance(found, str):
        raise NoLibrary(found)
    return found


def unit_of_stamps() -> float:
    """Return what the unit of the library's stamps is [s]: by both clocks, since the first call."""
    return load_clocks()()


@cache
def load_clocks() -> Callable[[], float]:
    """Compare the clocks a first time; return what compares them again, which is the more exact the later it is."""
    stamp = load().tick_stamp
    first, started = int(stamp()), perf_counter()

    def unit() -> float:
        return (perf_counter() - started) / max(1, int(stamp()) - first)

    return unit


@cache
def _load() -> ctypes.CDLL | str:
    shipped = FOLDER / f"tick-{platform_name()}.{ending()}"
    if shipped.is_file():
        with suppress(OSError, NoLibrary):  # of another C library: compile
            return opened(shipped)
    compiler = find_compiler()
    if compiler is None:
        return f"there is no C compiler in PATH ({', '.join(COMPILERS)}), nor a library in {FOLDER}; install one"
    try:
        return opened(compiled(compiler))
    except (OSError, NoLibrary) as error:
        return " ".join(str(error).split())


def platform_name() -> str:
    """Return system and machine, as in the name of a shipped library."""
    return f"{sys.platform}-{platform.machine().lower()}"


def ending() -> str:
    """Return how the names of shared libraries end here."""
    return _ENDINGS.get(sys.platform, "so")


def find_compiler() -> str | None:
    """Return the path of a C compiler: that of the variable CC, or one of the usual names."""
    names = (os.environ.get("CC", ""), *COMPILERS)
    return next((path for name in names if name and (path := shutil.which(name))), None)


def compiled(compiler: str) -> Path:
    """Return the library of this compiler, from the cache or made now; raise NoLibrary if it fails."""
    content = b"\0".join(path.read_bytes() for path in (*SOURCES, *HEADERS))
    key = "\0".join([compiler, str(Path(compiler).stat().st_mtime_ns), platform_name(), *OPTIONS]).encode()
    name = f"tick-{hashlib.sha256(key + content).hexdigest()[:24]}.{ending()}"
    folder = cache_folder()
    if folder is not None:
        path = folder / name
        with suppress(OSError):
            if path.is_file():
                return path
            _compile(compiler, folder, path)
            return path
    private = Path(
        tempfile.mkdtemp(prefix="lockstep-tick-")
    )  # the library stays open: it can go at once, or at the end
    _remove_at_exit(private)
    _compile(compiler, private, private / name)
    return private / name


def cache_folder() -> Path | None:
    """Return the folder of compiled libraries, which only this user can write; None if there cannot be one."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA")
    elif sys.platform == "darwin":
        base = str(Path("~/Library/Caches").expanduser())
    else:
        base = os.environ.get("XDG_CACHE_HOME") or str(Path("~/.cache").expanduser())
    if not base or not Path(base).is_absolute():
        return None
    folder = Path(base, "lockstep")
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not only_this_user_writes(folder):
            return None  # what others can write there would run here
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK | os.X_OK) else None


def _compile(compiler: str, folder: Path, path: Path) -> None:
    """Compile into a file of its own, and put it in place in one step: several runs may begin at once."""
    handle, partial = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=folder)
    os.close(handle)
    command = [compiler, *OPTIONS, "-o", partial, *map(str, SOURCES)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=_LONGEST, errors="replace")
        if done.returncode != 0:
            raise NoLibrary(f"{compiler} does not compile {SOURCES[0].name}: {done.stderr[-300:].strip()}")
        opened(Path(partial))
        Path(partial).replace(path)
    except subprocess.TimeoutExpired:
        raise NoLibrary(f"{compiler} did not compile {SOURCES[0].name} in {_LONGEST} s") from None
    finally:
        Path(partial).unlink(missing_ok=True)


def _remove_at_exit(folder: Path) -> None:
    atexit.register(shutil.rmtree, folder, ignore_errors=True)


def opened(path: Path) -> ctypes.CDLL:
    """Load a library and compare its structures with those here; OSError or NoLibrary if it cannot be used."""
    library = ctypes.CDLL(str(path))
    sizes = (ctypes.c_size_t * 3)()
    try:
        library.tick_layout.restype = None
        library.tick_layout(sizes)
        library.tick_run.argtypes, library.tick_run.restype = (ctypes.c_void_p,), ctypes.c_int
        library.tick_step.argtypes, library.tick_step.restype = (ctypes.c_void_p, ctypes.c_int64), ctypes.c_int
        library.pool_open.argtypes, library.pool_open.restype = (ctypes.c_void_p, ctypes.c_int32), ctypes.c_void_p
        library.pool_close.argtypes, library.pool_close.restype = (ctypes.c_void_p,), None
        waiting = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double)
        library.job_finish.argtypes, library.job_finish.restype = waiting, ctypes.c_int32
        library.tick_stamp.argtypes, library.tick_stamp.restype = (), ctypes.c_uint64
    except AttributeError as error:
        raise NoLibrary(f"{path}: {error}") from None
    wanted = [LAYOUT, ctypes.sizeof(TickOperation), ctypes.sizeof(TickState)]
    if list(sizes) != wanted:
        raise NoLibrary(f"{path}: has structures of {list(sizes)} bytes, not {wanted}")
    return library
