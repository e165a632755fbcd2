"""Write a whole system as one co-simulation FMU: its binary is the C tick, its resources are the FMUs."""
