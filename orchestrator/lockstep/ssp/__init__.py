"""Read, flatten and write system files in SSP 1.0."""
