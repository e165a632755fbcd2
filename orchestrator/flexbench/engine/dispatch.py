"""Give tasks to a pool, a few more than it carries out at once, and yield what comes of them as it comes."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from lockstep.errors import RunError

from .content import File
from .pools import GONE, Answer, ClusterLost, DaskPool, Pool
from .tasks import TRIES, Missing, NoResult, Task, TaskOutcome

_AHEAD = 2  # tasks that wait in the pool for each under way
_LOOK = 0.2  # s between two calls of `idle`
_OFTEN = 20  # times that files are sent for one task: others may come between, if workers come and go


def dispatch(tasks: Iterable[Task], pool: Pool, idle: Callable[[], None] = lambda: None) -> Iterator[TaskOutcome]:
    """Carry out tasks; yield the outcome of each, in the order in which they end.

    Parameters
    ----------
    tasks : in the order in which they are begun
    pool : that carries them out; it is left open, unless this generator is ended by an exception
    idle : called now and then while tasks are under way

    Raises
    ------
    NoResult
        If a machine cannot do what a task needs, in a second attempt too, or its disk is full.
    ClusterLost
        If the scheduler is gone.
    """
    waiting = deque[Task]()
    source = iter(tasks)
    pending: dict[Future[Answer], Task] = {}
    sent: dict[int, int] = {}
    lost: dict[int, int] = {}
    try:
        while True:
            while len(pending) < _AHEAD * pool.size + 1:
                task = waiting.popleft() if waiting else next(source, None)
                if task is None:
                    break
                pending[pool.submit(task)] = task
            if not pending:
                return
            ended, _ = wait(pending, timeout=_LOOK, return_when=FIRST_COMPLETED)
            idle()
            for future in ended:
                task = pending.pop(future)
                try:
                    answer = future.result()
                except (KeyboardInterrupt, RunError):
                    raise
                except (Exception, CancelledError) as error:
                    lost[task.number] = lost.get(task.number, 0) + 1
                    outcome = _vanished(error, task, pool, lost[task.number])
                    if outcome is None:
                        waiting.append(task)
                    else:
                        yield outcome
                    continue
                if isinstance(answer, Missing):
                    sent[task.number] = sent.get(task.number, 0) + 1
                    if sent[task.number] > _OFTEN:
                        raise RunError(f"{task.title}: its files do not reach {answer.worker}; has it disk space?")
                    pending[pool.submit(task, _contents(answer, pool.settings.store), answer.worker)] = task
                elif isinstance(answer.error, NoResult):
                    raise answer.error
                else:
                    yield answer
    except BaseException:
        for future in pending:
            future.cancel()
        pool.end()
        raise


def _contents(missing: Missing, store: Path | None) -> dict[File, bytes]:
    assert store is not None
    return {file: (store / file.name).read_bytes() for file in missing.files}


def _vanished(error: BaseException, task: Task, pool: Pool, times: int) -> TaskOutcome | None:
    """Return the outcome of a task whose worker vanished; None to begin it again; raise what is no such end."""
    if isinstance(pool, DaskPool) and pool.lost(error):
        raise ClusterLost(GONE) from None
    gone = isinstance(error, CancelledError | BrokenProcessPool | OSError) or type(error).__name__ == "KilledWorker"
    if not gone:
        raise error
    if isinstance(error, BrokenProcessPool):
        raise RunError("the executor's processes ended; start it and repeat the command") from None
    if times < TRIES:
        return None
    return TaskOutcome(number=task.number, failure="vanished", cause="its worker vanished", attempts=times)
