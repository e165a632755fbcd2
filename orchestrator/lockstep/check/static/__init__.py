"""Checks of an FMU that read its archive and never load its library."""
