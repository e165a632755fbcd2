"""Between a foreign FMU and the ports of a component of ours: what a TOML file says of names, units, conventions."""
