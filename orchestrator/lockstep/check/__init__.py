"""Acceptance checks of one FMI 2.0 co-simulation FMU, whoever made it."""
