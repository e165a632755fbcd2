"""Native FMUs: the run-time steppers as C99, with what each needs generated from the same ports and matrices."""
