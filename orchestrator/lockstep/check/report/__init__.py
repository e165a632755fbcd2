"""Findings of a check and the reports made from them."""
