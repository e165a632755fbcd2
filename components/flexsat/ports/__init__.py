"""What the components show the world: ports, units, and the parameters of a run. Free of FMI and of pythonfmu."""
