"""The interface document of the FMUs: what each port is, where it comes from and where it goes."""
