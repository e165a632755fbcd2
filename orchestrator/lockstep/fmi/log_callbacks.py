"""Log messages of FMUs: find the instance to which a message belongs."""

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from itertools import count
from weakref import WeakValueDictionary

from lockstep.fmi.slave import OK

Log = Callable[[str, int, str, str], None]  # component, status, category, message
Listener = Callable[[int, str, str, str], None]  # status, category, name of the instance as the FMU gives it, message

# fmpy's proxy, which fills in the variadic arguments of a message, knows one logger for the whole process: the
# last one given. So there is one, and it finds the instance by the environment that an FMU passes through.
_instances: WeakValueDictionary[int, "Messages"] = WeakValueDictionary()
_environments = count(1)


class Messages:
    """The messages of one instance. `environment` is the number that the FMU has to pass through."""

    def __init__(self, component: str, log: Log, listener: Listener | None = None) -> None:
        self._component = component
        self._log = log
        self._listener = listener
        self._last: deque[str] = deque(maxlen=3)
        self.last_status = OK  # of the last message above OK
        self.keep: Callable[[], bool] | None = None  # asked at a message whether it is kept, for `report_kept`
        self._kept: list[tuple[bytes | None, int, bytes | None, bytes]] = []
        self.environment = next(_environments)
        _instances[self.environment] = self

    def take(self, name: bytes | None, status: int, category: bytes | None, message: bytes) -> None:
        """Keep a message above OK and log it; report every message to the listener."""
        if status == OK and self._listener is None:
            return
        if self.keep is not None and self.keep():
            self._kept.append((name, status, category, message))
            return
        words = [(part or b"").decode("utf-8", "replace") for part in (category, name, message)]
        text = words[2].strip()
        if self._listener is not None:
            self._listener(status, words[0], words[1], text)
        if status != OK:
            self._last.append(" ".join(text.split()))
            self.last_status = status
            self._log(self._component, status, words[0], text)

    def report_kept(self) -> None:
        """Log the messages that were kept."""
        kept, self._kept = self._kept, []
        for message in kept:
            self.take(*message)

    def last(self) -> str:
        """Return what was logged last above OK."""
        return " | ".join(self._last)

    def is_of(self, name: bytes | None) -> bool:
        """Return whether the instance has this name."""
        return self._component.encode() == name


def take_message(
    environment: int | None, name: bytes | None, status: int, category: bytes | None, message: bytes
) -> None:
    """Pass a message to the instance that it belongs to. Called by C: it raises nothing."""
    with suppress(Exception):
        found = _instances.get(environment or 0)
        if found is None:  # an FMU that does not pass the environment through
            found = max((each for each in _instances.values() if each.is_of(name)), key=lambda each: each.environment)
        found.take(name, status, category, message)
