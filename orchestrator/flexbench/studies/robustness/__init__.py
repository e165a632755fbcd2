"""Robustness to errors of the modal frequencies."""
