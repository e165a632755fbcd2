"""What master and C share of the connection to one worker: `tick/c/requests.h` has the same structure.

A request is made in Python by `Connection`, or in C by the tick; both count here. Only one of them waits for an answer:
`asking` says who.
"""

from __future__ import annotations

from ctypes import Structure, c_double, c_int32, c_int64, c_void_p

NOBODY, PYTHON = 0, -1  # asking; above 0 it is the number of a request of the tick in C


class WorkerLink(Structure):
    """worker_link."""

    _fields_ = [
        ("numbers", c_void_p),  # of request and answer, in the shared memory
        ("reals", c_void_p),  # of the last call, there too
        ("number", c_int64),  # of the last request
        ("by_c", c_int64),  # how many requests C has made
        ("busy_since", c_double),  # when that was made, on the monotonic clock [s]; 0: none is under way
        ("messages", c_int64),  # since the last judgement of the cores, as all that follows
        ("since", c_double),  # when one of them was sent, on the processor clock of the master [s]
        ("overlap", c_double),  # [s] of work of others while it had something to do
        ("step", c_double),  # [s] of work for a message, on average, before that
        ("commands", c_int32),  # descriptors
        ("answers", c_int32),
        ("asking", c_int32),
        ("timed", c_int32),  # whether the overlap with the request under way is measured
    ]
