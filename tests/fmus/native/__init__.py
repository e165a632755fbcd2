"""Twins in C of the run-time steppers, as shared libraries that tests call without FMI."""
