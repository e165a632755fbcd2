"""Checks of an FMU that call its library, each in a process of its own."""
