"""Describe systems of components and connections as frozen values."""
