"""The interface control document of the FMUs: meaning, unit, range, source and destination of each port."""
