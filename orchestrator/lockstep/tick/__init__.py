"""The tick: a flat table of operations, executed by one of two equal implementations, in Python or in C."""
