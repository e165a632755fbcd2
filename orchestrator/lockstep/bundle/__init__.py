"""Write a whole system as one co-simulation FMU of FMI 2.0: its binary is the C tick, its resources are the FMUs."""
