"""FMI shells: ports and life cycle around the run-time steppers, no arithmetic."""
