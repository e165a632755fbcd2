"""The version of the distribution, which `pyproject.toml` reads here."""

VERSION = "0.1.0"
