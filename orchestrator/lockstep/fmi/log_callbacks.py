"""What FMUs log: one place that finds the instance to which a message belongs."""

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from itertools import count
from weakref import WeakValueDictionary

from lockstep.fmi.slave import OK

Log = Callable[[str, int, str, str], None]  # component, status, category, message

# fmpy's proxy, which fills in the variadic arguments of a message, knows one logger for the whole process: the
# last one given. So there is one, and it finds the instance by the environment that an FMU hands through.
_instances: WeakValueDictionary[int, "Messages"] = WeakValueDictionary()
_environments = count(1)


class Messages:
    """The messages of one instance. `environment` is the number that it has to hand through."""

    def __init__(self, component: str, log: Log) -> None:
        self._component = component
        self._log = log
        self._last: deque[str] = deque(maxlen=3)
        self.environment = next(_environments)
        _instances[self.environment] = self

    def take(self, status: int, category: str, message: str) -> None:
        """Take a message."""
        self._last.append(" ".join(message.split()))
        self._log(self._component, status, category, message)

    def last(self) -> str:
        """Return what was logged last above OK."""
        return " | ".join(self._last)

    def is_of(self, name: bytes | None) -> bool:
        """Tell whether this is the instance of that name."""
        return self._component.encode() == name


def take_message(environment: int | None, name: bytes | None, status: int, category: bytes, message: bytes) -> None:
    """Find the instance of a message above OK and hand it over. Called by C: it raises nothing."""
    if status == OK:
        return
    with suppress(Exception):
        found = _instances.get(environment or 0)
        if found is None:  # an FMU that does not hand the environment through
            found = max((each for each in _instances.values() if each.is_of(name)), key=lambda each: each.environment)
        found.take(status, (category or b"").decode("utf-8", "replace"), message.decode("utf-8", "replace").strip())
