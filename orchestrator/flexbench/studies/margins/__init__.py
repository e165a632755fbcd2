"""Stability margins of the loop broken at the plant input: of the design, and measured through the FMUs."""
