"""The tick: a flat table of operations, executed by one of two equal implementations, in Python or in C."""

IMPLEMENTATIONS = ("auto", "python", "c")  # auto: in C where the library can be had
