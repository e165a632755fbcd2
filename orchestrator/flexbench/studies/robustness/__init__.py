"""Robustness to errors of the plant that the controller does not know."""
