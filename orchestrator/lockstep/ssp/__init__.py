"""System files in SSP 1.0: reading, flattening and writing."""
