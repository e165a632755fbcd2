"""Ports, units, and the parameters of a run of each component. Free of FMI and of pythonfmu."""
