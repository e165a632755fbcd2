"""One FMU in a worker's process, and what became of it."""

from lockstep.fmi.slave import FATAL, Slave


class HostedFmu:
    """A slave whose failures are noted."""

    def __init__(self, slave: Slave) -> None:
        self.slave = slave
        self.fatal = False  # nothing of its library may run any more

    def failed(self, call: str, status: int) -> str:
        """Note that a call returned a status above WARNING; describe that."""
        self.slave.failed(status)
        self.fatal = self.fatal or status >= FATAL
        return self.slave.outcome(call, status)
