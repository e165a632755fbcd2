"""What Linux alone offers, behind functions; without it a run goes on, but isolated FMUs need `can_isolate`.

No other module imports `fcntl` or `resource`, reads `/proc`, or calls `os.memfd_create`, `os.sched_setaffinity`,
`signal.pthread_sigmask` and the like: a test refuses that.
"""

from __future__ import annotations

import ctypes
import errno
import mmap
import os
import signal
import socket
import sys
import warnings
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

import psutil

_CURRENT_PERSONALITY, _SAME_LAYOUT = 0xFFFFFFFF, 0x0040000  # linux/personality.h: ADDR_NO_RANDOMIZE
_PARENT_DEATH_SIGNAL, _CHILD_SUBREAPER = 1, 36  # linux/prctl.h: PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER

LOCK = ".lock"  # file in a locked folder, where a folder itself cannot be locked

KILLED = -getattr(signal, "SIGKILL", 9)  # exit code of a process that was killed

Release = Callable[[], None]


def _optional(name: str) -> Any:
    """Import a module that not every system has; None where it is missing."""
    try:
        return import_module(name)
    except ImportError:
        return None


_fcntl, _resource = _optional("fcntl"), _optional("resource")


def can_isolate() -> bool:
    """Return whether FMUs can run in processes of their own, with shared memory between them and the master."""
    return hasattr(os, "memfd_create") and os.name == "posix"


def lock_file(path: Path) -> Release | None:
    """Create and lock a file until the returned function is called or this process ends.

    None if another process holds the lock. Raises OSError where the file cannot be made or locked at all.
    """
    if _fcntl is None:
        return _lock_beside(path)
    return _lock_descriptor(os.open(path, os.O_CREAT | os.O_RDWR, 0o666))


def lock_folder(folder: Path) -> Release | None:
    """Lock a folder until the returned function is called or this process ends; None if another holds the lock.

    The folder itself is locked where the system can do that, so that nothing is left in it by a process that is
    killed; elsewhere a file in it. Raises OSError where the folder cannot be opened or locked at all.
    """
    if _fcntl is not None:
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        with suppress(OSError):  # NFS locks only what is open for writing
            return _lock_descriptor(descriptor)
    return lock_file(folder / LOCK)


def _lock_descriptor(descriptor: int) -> Release | None:
    """Lock what is open, or close it: None if another process holds the lock, OSError where there are no locks."""
    try:
        _fcntl.flock(descriptor, _fcntl.LOCK_EX | _fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        return None
    except BaseException:
        os.close(descriptor)
        raise

    def unlock() -> None:
        _fcntl.flock(descriptor, _fcntl.LOCK_UN)  # a process that an FMU has forked may still have it open
        os.close(descriptor)

    return unlock


def names_living_process(lock: Path, written: float) -> bool:
    """Return whether the process whose number stands in a file, written at that time, still lives."""
    with suppress(ValueError):
        return process_lives(int(lock.read_text()), written)
    return False


def process_lives(number: int, then: float) -> bool:
    """Return whether the process of a number that lived at a time [s] lives still."""
    with suppress(psutil.Error):
        return bool(psutil.Process(number).create_time() <= then)  # later: another one, of the same number
    return False


def _lock_beside(path: Path) -> Release | None:
    """Lock a file by another one next to it. `filelock` is imported here alone: it takes long."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it warns where it has to do without the system's locks
        filelock = import_module("filelock")
    lock = filelock.FileLock(f"{path}.lock")
    try:
        lock.acquire(timeout=0)
    except filelock.Timeout:
        return None
    return lambda: lock.release()


def available_cores() -> set[int]:
    """Return the cores that the calling thread may run on."""
    if hasattr(os, "sched_getaffinity"):
        return set(os.sched_getaffinity(0))
    return set(range(os.cpu_count() or 1))


def pin(thread: int, to: Collection[int]) -> None:
    """Restrict a thread to these cores; do nothing for one that has ended, or where that is impossible."""
    if hasattr(os, "sched_setaffinity"):
        with suppress(OSError):
            os.sched_setaffinity(thread, to)


def use_core(core: int) -> Release:
    """Keep the calling thread on one core until the returned function is called.

    Raises OSError where there is no such core for this program, or none can be chosen.
    """
    if not hasattr(os, "sched_setaffinity"):
        raise OSError(errno.ENOSYS, "this system does not let a program choose")
    before = os.sched_getaffinity(0)
    if core not in before:
        raise OSError(errno.EINVAL, f"this program may use {', '.join(map(str, sorted(before)))}")
    os.sched_setaffinity(0, {core})
    return lambda: os.sched_setaffinity(0, before)


def use_priority(priority: int) -> Release:
    """Give the calling thread a real-time priority (SCHED_FIFO) until the returned function is called.

    Threads and processes that it starts do not inherit it. Raises OSError where that is not there or not permitted.
    """
    if not hasattr(os, "sched_setscheduler"):
        raise OSError(errno.ENOSYS, "this system has none")
    least, most = os.sched_get_priority_min(os.SCHED_FIFO), os.sched_get_priority_max(os.SCHED_FIFO)
    if not least <= priority <= most:
        raise OSError(errno.EINVAL, f"this system has {least} to {most}")
    policy, parameter = os.sched_getscheduler(0), os.sched_getparam(0)
    os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))

    def restore() -> None:
        with suppress(OSError):  # who may not clear the flag keeps it
            os.sched_setscheduler(0, policy, parameter)
            return
        os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, parameter)

    return restore


def current_core() -> int:
    """Return the core that the calling thread is on."""
    return int(_c_library().sched_getcpu())


def thread_times(thread: int) -> tuple[float, float]:
    """Return how long a thread has run, and has waited for a core [s], or raise OSError."""
    ran, waited, _ = Path(f"/proc/{thread}/schedstat").read_text().split()
    return int(ran) / 1e9, int(waited) / 1e9


@contextmanager
def same_memory_layout() -> Iterator[None]:
    """Give processes that are started in this block the same memory layout, if the system permits.

    What a core has learnt about the branches of Python in one worker then holds in the next. The layout is random as a
    defence against bad data; a worker runs foreign code anyhow.
    """
    before = _personality(_CURRENT_PERSONALITY)
    if before != -1:
        _personality(before | _SAME_LAYOUT)
    try:
        yield
    finally:
        if before != -1:
            _personality(before)


def _personality(number: int) -> int:
    return int(_c_library().personality(number)) if sys.platform == "linux" else -1


@contextmanager
def working_directory(folder: Path) -> Iterator[None]:
    """Change the working directory of this process in this block: only where no other thread relies on it."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def anonymous_memory(size: int) -> int:
    """Return the descriptor of a new file in memory; it has no name that could be left behind."""
    file = os.memfd_create("exchanged values")
    os.ftruncate(file, size)
    return file


def unnamed_file(folder: Path) -> int | None:
    """Return the descriptor of a new file in a folder, which vanishes when it is closed; None where there are none.

    It can be opened at its `descriptor_path`, and gets a name for good from `name_file`.
    """
    if sys.platform != "linux" or not Path("/proc/self/fd").is_dir():
        return None
    try:
        return os.open(folder, os.O_TMPFILE | os.O_RDWR, 0o666)
    except OSError:  # the file system has none
        return None


def descriptor_path(file: int) -> str:
    """Return a path at which this process can open a file that has no name."""
    return f"/proc/self/fd/{file}"


def name_file(file: int, path: Path) -> None:
    """Give an unnamed file a name, which nothing else may have."""
    here = os.open("/", os.O_RDONLY)
    try:
        os.link(descriptor_path(file), path.absolute(), src_dir_fd=here)  # linkat, which follows the link
    finally:
        os.close(here)


def hide_from_copies(memory: mmap.mmap) -> None:
    """Leave memory out of copies of this process: a copy that touches it crashes."""
    if hasattr(mmap, "MADV_DONTFORK"):
        memory.madvise(mmap.MADV_DONTFORK)


def limit_process(*, core: int | None = None, data: int | None = None, file_size: int | None = None) -> None:
    """Limit this process's core files, data and written files [bytes], as far as the system can."""
    if _resource is None:
        return
    for name, value in (("RLIMIT_CORE", core), ("RLIMIT_DATA", data), ("RLIMIT_FSIZE", file_size)):
        if value is not None:
            kind = getattr(_resource, name)
            _, hard = _resource.getrlimit(kind)
            soft = value if hard == _resource.RLIM_INFINITY else min(value, hard)
            _resource.setrlimit(kind, (soft, hard))


def refuses_programs(folder: Path) -> bool:
    """Return whether a folder is on a file system from which no library can be loaded: mounted `noexec`."""
    with suppress(OSError):  # one that is not there is reported when something is written to it
        return hasattr(os, "ST_NOEXEC") and bool(os.statvfs(folder).f_flag & os.ST_NOEXEC)
    return False


def only_this_user_writes(folder: Path) -> bool:
    """Return whether no other user can write into a folder, as far as the system knows users by number."""
    status = folder.stat()
    return not hasattr(os, "getuid") or (status.st_uid == os.getuid() and not status.st_mode & 0o022)


def physical_memory() -> int:
    """Return the memory of this machine [bytes]."""
    return int(psutil.virtual_memory().total)


def resident_memory() -> int:
    """Return how much memory this process occupies [bytes]."""
    return int(psutil.Process().memory_info().rss)


def end_with_parent(number: int | None = None) -> None:
    """Have the system send this process a signal when its parent ends: SIGKILL if no other is given."""
    if sys.platform == "linux":
        _c_library().prctl(_PARENT_DEATH_SIGNAL, number or signal.SIGKILL)


def adopt_orphans() -> None:
    """Have descendants whose parents end become children of this process."""
    if sys.platform == "linux":
        _c_library().prctl(_CHILD_SUBREAPER, 1, 0, 0, 0)


def copy_process() -> int:
    """Copy this process; return the number of the copy, and 0 in it."""
    return os.fork()


def wait_for_child(process: int) -> int:
    """Wait for the end of this child and return its exit code, negative for a signal; others are reaped meanwhile."""
    while True:
        ended, status = os.waitpid(-1, 0)
        if ended == process:
            return os.waitstatus_to_exitcode(status)


def wait_without_reaping(process: int) -> int:
    """Wait for the end of this child and return its exit code, negative for a signal; its number stays its own."""
    found = os.waitid(os.P_PID, process, os.WEXITED | os.WNOWAIT)
    assert found is not None
    return int(found.si_status) if found.si_code == os.CLD_EXITED else -int(found.si_status)


def can_serve_copies() -> bool:
    """Return whether a process that has imported numpy can be copied at any time, and get descriptors."""
    return sys.platform == "linux" and hasattr(socket, "SOCK_SEQPACKET")


def new_session() -> None:
    """Make this process the first of a new session."""
    os.setsid()


def reap() -> bool:
    """Reap the children that have ended; return whether there are others."""
    with suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
        return True
    return False


def kill(process: int) -> None:
    """Kill a process; do nothing if it has ended."""
    with suppress(ProcessLookupError):
        os.kill(process, signal.SIGKILL)


def was_killed(code: int) -> bool:
    """Return whether an exit code of `subprocess` is that of a process that was killed from outside."""
    return code == KILLED


def end_like(code: int) -> NoReturn:
    """End this process with an exit code, or by a signal if it is negative."""
    if code < 0:
        limit_process(core=0)
        with suppress(OSError):  # it cannot be handled
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    os._exit(abs(code))


def close_descriptors(*, but: int) -> None:
    """Close all descriptors of this process except one and those of the standard streams."""
    os.closerange(3, but)
    os.closerange(but + 1, os.sysconf("SC_OPEN_MAX"))


def has_fork() -> bool:
    """Return whether a process can be copied."""
    return hasattr(os, "fork")


def session_of(process: int) -> int:
    """Return the session of a process, or raise OSError; -1 where there are no sessions."""
    return os.getsid(process) if hasattr(os, "getsid") else -1


@contextmanager
def interrupts_held_back(signals: Collection[int]) -> Iterator[None]:
    """Hold signals back in this block; processes started in it do so until `accept_interrupts`."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def accept_interrupts(signals: Collection[int]) -> None:
    """Accept signals in a process that was started in `interrupts_held_back`; Ctrl-C even if a parent ignores it."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # a background job of a shell
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, signals)


@cache
def _c_library() -> ctypes.CDLL:
    return ctypes.CDLL(None)
