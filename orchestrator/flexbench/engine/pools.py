"""Where tasks are carried out: processes on this machine, a Dask cluster, or any executor of `concurrent.futures`."""

from __future__ import annotations

import logging
import uuid
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

from lockstep.errors import InputError, RunError
from lockstep.operating_system import available_cores

from .content import File
from .tasks import (
    DiskFull,
    Missing,
    Task,
    TaskOutcome,
    TaskSettings,
    carry_out,
    end_workers,
    forget_workers,
    listen,
)
from .worker import Silence

Answer = TaskOutcome | Missing
_CONNECT = 10.0  # s to wait for a scheduler
GONE = "the scheduler does not answer any more; start it and repeat the command"


class ClusterLost(RunError):
    """The scheduler of a cluster does not answer any more."""


class Pool(Protocol):
    """Something that carries out tasks."""

    settings: TaskSettings

    @property
    def size(self) -> int:
        """How many tasks it carries out at once, as far as it is known now."""

    @property
    def text(self) -> str:
        """What it is, for a line of text."""

    def submit(self, task: Task, contents: Mapping[File, bytes] | None = None, to: str = "") -> Future[Answer]:
        """Begin a task; with files that its machine lacks."""

    def end(self) -> None:
        """Have tasks under way raise KeyboardInterrupt, with what they write closed."""

    def close(self) -> None:
        """Wait for tasks under way and end all processes."""


def settings_of(limit: float | None = None, store: Path | None = None) -> TaskSettings:
    """Return the settings of a new pool; `limit` is how long a task may show no progress [s]."""
    silence = Silence() if limit is None else Silence(limit=limit)
    return TaskSettings(pool=uuid.uuid4().hex, silence=silence, store=None if store is None else store.absolute())


class LocalPool:
    """Processes on this machine, one a core if no number is given. Each lives until the pool is closed."""

    def __init__(
        self,
        settings: TaskSettings,
        size: int | None = None,
        listener: Callable[[int, float, float], None] | None = None,
    ) -> None:
        self.settings = settings
        self.size = size or len(available_cores())
        self._executor = ThreadPoolExecutor(self.size)  # a thread waits for its process
        if listener is not None:
            listen(settings.pool, listener)

    @property
    def text(self) -> str:
        """What it is, for a line of text."""
        return f"{self.size} process{'es' if self.size > 1 else ''}"

    def submit(self, task: Task, contents: Mapping[File, bytes] | None = None, to: str = "") -> Future[Answer]:  # noqa: ARG002
        """Begin a task."""
        return self._executor.submit(carry_out, task, self.settings, contents)

    def end(self) -> None:
        """Interrupt the processes."""
        end_workers(self.settings.pool)

    def close(self) -> None:
        """Wait for the processes to end."""
        self._executor.shutdown(wait=True, cancel_futures=True)
        forget_workers(self.settings.pool)


class GivenPool:
    """An executor of the caller, which he shuts down himself. Its worker processes end once they are idle for long."""

    def __init__(self, executor: Executor, settings: TaskSettings, size: int = 1) -> None:
        self._executor, self.settings, self.size = executor, settings, size

    @property
    def text(self) -> str:
        """What it is, for a line of text."""
        return type(self._executor).__name__

    def submit(self, task: Task, contents: Mapping[File, bytes] | None = None, to: str = "") -> Future[Answer]:  # noqa: ARG002
        """Begin a task."""
        return self._executor.submit(carry_out, task, self.settings, contents)

    def end(self) -> None:
        """Interrupt what is under way in this process; tasks in other processes end by themselves."""
        end_workers(self.settings.pool)

    def close(self) -> None:
        """End the processes that this one started."""
        forget_workers(self.settings.pool)


class DaskPool:
    """A Dask cluster. Its workers need the same version of flexsat; files reach them with the first task of each."""

    def __init__(self, address: str, settings: TaskSettings) -> None:
        self._distributed = _dask()
        self.settings = settings
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what it notes on lost workers, we report
        try:
            self._client = self._distributed.Client(address, timeout=_CONNECT, set_as_default=False)
        except (OSError, ValueError, TypeError, ImportError) as error:
            reason = " ".join(str(error).split())
            raise InputError(
                f"--scheduler {address}: does not answer ({reason}); start one with `dask scheduler`, and workers with"
                " `dask worker`"
            ) from None
        self._executor = self._client.get_executor(pure=False)

    @property
    def size(self) -> int:
        """Threads of all workers, as far as the scheduler says; ClusterLost if it is gone."""
        if self._client.status in ("closing", "closed"):
            raise ClusterLost(GONE)
        workers = self._client.scheduler_info(n_workers=-1).get("workers", {})
        return max(1, sum(int(one["nthreads"]) for one in workers.values()))

    @property
    def text(self) -> str:
        """What it is, and where its dashboard is."""
        count = len(self._client.scheduler_info(n_workers=-1).get("workers", {}))
        dashboard = self._client.dashboard_link
        return f"{count} Dask worker{'s' if count != 1 else ''}" + (f", dashboard {dashboard}" if dashboard else "")

    def submit(self, task: Task, contents: Mapping[File, bytes] | None = None, to: str = "") -> Future[Answer]:
        """Begin a task, where files come with it on the machine that asked for them."""
        sent: Any = None
        where: dict[str, Any] = {}
        if contents:
            where = {"workers": [to], "allow_other_workers": True}
            sent = self._client.scatter(dict(contents), workers=[to], hash=True)
        settings = replace(self.settings, store=None)  # files travel: the folder may be on no machine but this
        future: Future[Answer] = self._executor.submit(carry_out_on_cluster, task, settings, sent, **where)
        return future

    def end(self) -> None:
        """Interrupt the processes of all workers."""
        if self._client.status == "running":
            self._client.run(end_workers, self.settings.pool, wait=False)

    def close(self) -> None:
        """End the processes of all workers, and leave the cluster as it is."""
        if self._client.status == "running":
            self._client.run(forget_workers, self.settings.pool, on_error="ignore")
        self._client.close(timeout=5.0)

    def lost(self, error: BaseException) -> bool:
        """Return whether an error says that the cluster, or the place of a task in it, is gone."""
        return self._client.status != "running" or isinstance(error, self._distributed.comm.core.CommClosedError)


def carry_out_on_cluster(task: Task, settings: TaskSettings, contents: Mapping[File, bytes] | None) -> Answer:
    """Carry out a task in a thread of a Dask worker, whose address is its name."""
    address = _dask().get_worker().address
    return replace(carry_out(task, settings, contents), worker=address)


def _dask() -> Any:
    try:
        return import_module("distributed")
    except ImportError:
        raise InputError("--scheduler: needs Dask: `pip install flexsat[dask]`") from None


__all__ = ["ClusterLost", "DaskPool", "DiskFull", "GivenPool", "LocalPool", "Pool", "settings_of"]
