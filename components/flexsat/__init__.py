"""The spacecraft: physics, control design, run-time steppers, FMU shells and export."""
