"""Measured latency and feedthrough of an FMU."""
