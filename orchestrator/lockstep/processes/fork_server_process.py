"""Import modules once, and run their functions in copies of this process: `python -m ... SOCKET MODULE...`.

A request is what `fork_server` sends: a function with its arguments, a working directory, and two descriptors, for what
is printed and for the guard's reports. Each copy has a guard, as a process of its own has (`guard`).
"""

from __future__ import annotations

import gc
import json
import os
import socket
import sys
from importlib import import_module

from lockstep.operating_system import copy_process, end_with_parent, new_session, reap, wait_without_reaping
from lockstep.processes.guard import guard_copy

LARGEST = 65536  # bytes of a request or an answer


def main(arguments: list[str]) -> int:
    """Serve the requests that come through a socket, one after another, until its other end is closed."""
    channel = socket.socket(fileno=int(arguments[0]))
    channel.set_inheritable(False)
    end_with_parent()
    for name in arguments[1:]:
        import_module(name)
    gc.collect()
    gc.freeze()  # copies do not touch what is there, so that the memory stays shared
    while True:
        message, descriptors, *_ = socket.recv_fds(channel, LARGEST, 2)
        if not message:
            return 0
        guard = copy_process()
        if not guard:
            return _become(json.loads(message), channel, descriptors)
        for descriptor in descriptors:
            os.close(descriptor)
        channel.send(b"%d" % guard)
        channel.send(b"%d" % wait_without_reaping(guard))  # until it is reaped, nothing else has its number
        if not channel.recv(1):
            return 0
        reap()


def _become(request: dict[str, str | list[str]], channel: socket.socket, descriptors: list[int]) -> int:
    """Guard a copy of this process, and run the function of a request in that."""
    channel.close()
    new_session()
    printed, report = descriptors
    for stream in (1, 2):
        os.dup2(printed, stream)
    os.close(printed)
    os.chdir(str(request["directory"]))
    guard_copy(report)
    module, _, name = str(request["function"]).partition(":")
    sys.argv = [module, *request["arguments"]]
    return int(getattr(import_module(module), name)(request["arguments"]))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
