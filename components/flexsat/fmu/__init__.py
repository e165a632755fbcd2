"""Exported FMUs: built from ports, run-time steppers and design, with their documentation."""
