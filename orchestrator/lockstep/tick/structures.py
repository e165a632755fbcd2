"""The structures of `c/tick.h`, field for field."""

from __future__ import annotations

from ctypes import Structure, c_double, c_int32, c_int64, c_size_t, c_uint32, c_uint64, c_void_p
from enum import IntEnum

LAYOUT = 8
PARTS = 5  # of a row: all but texts


class Kind(IntEnum):
    """What an operation does."""

    CALLER = 0
    GATHER_4 = 1
    GATHER_8 = 2
    SCATTER_4 = 3
    SCATTER_8 = 4
    CONVERT = 5
    FINITE = 6
    VALUES = 7
    ARRAYS = 8
    STEP_1 = 9
    STEP_2 = 10
    STEP_3 = 11
    ROW = 12
    RECORD_REALS = 13
    RECORD_INTEGERS = 14
    RECORD_WIDE = 15
    ADD = 16
    MULTIPLY = 17
    HOLD_4 = 18
    HOLD_8 = 19
    DELAY_4 = 20
    DELAY_8 = 21
    WIDEN = 22
    NARROW = 23
    BEGIN = 24
    FINISH = 25
    PACE = 26
    REQUEST = 27
    ANSWER = 28
    COPY = 29
    RECORD_COPY = 30


class Reason(IntEnum):
    """Why `tick_run` returned."""

    DONE = 0
    CALLER_ACTS = 1
    STATUS = 2
    NOT_FINITE = 3
    ROWS_FULL = 4
    LOOK = 5
    AT_LAST = 6


class TickOperation(Structure):
    """tick_operation."""

    _fields_ = [
        ("kind", c_uint32),
        ("part", c_uint32),
        ("account", c_uint32),
        ("function", c_void_p),
        ("instance", c_void_p),
        ("references", c_void_p),
        ("count", c_size_t),
        ("values", c_size_t),
        ("buffer", c_void_p),
        ("source", c_void_p),
        ("index", c_void_p),
        ("first", c_void_p),
        ("second", c_void_p),
        ("marks", c_void_p),
        ("length", c_double),
        ("from_", c_int64),
        ("until", c_int64),
        ("memory", c_void_p),
        ("history", c_void_p),
    ]


class TickRows(Structure):
    """tick_rows."""

    _fields_ = [
        ("times", c_void_p),
        ("parts", c_void_p * PARTS),
        ("strides", c_size_t * PARTS),
        ("count", c_size_t),
        ("size", c_size_t),
    ]


class TickState(Structure):
    """tick_state."""

    _fields_ = [
        ("operations", c_void_p),
        ("order", c_void_p),
        ("begins", c_void_p),
        ("ends", c_void_p),
        ("cycle", c_uint64),
        ("origin", c_int64),
        ("length", c_int64),
        ("second", c_double),
        ("tick", c_int64),
        ("until", c_int64),
        ("position", c_uint64),
        ("begun", c_int32),
        ("status", c_uint32),
        ("time", c_double),
        ("look", c_int32),
        ("rows", TickRows),
        ("pool", c_void_p),
        ("jobs", c_void_p),
        ("spent", c_void_p),
        ("stamp", c_uint64),
        ("account", c_uint32),
        ("links", c_void_p),
        ("link_count", c_int64),
    ]
