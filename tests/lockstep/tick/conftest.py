"""A signal of Ctrl-C to this process."""

import signal
import threading
from contextlib import contextmanager

import pytest


@pytest.fixture
def interrupt_after():
    """Return a context in which SIGINT comes after so many seconds."""

    @contextmanager
    def sent(delay):
        timer = threading.Timer(delay, signal.raise_signal, (signal.SIGINT,))
        timer.start()
        try:
            yield
        finally:
            timer.cancel()
            timer.join()

    return sent
