"""Adapt a foreign FMU to the interface ports of a component: names, units and conventions from a TOML file."""
