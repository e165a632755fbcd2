"""What travels in an FMU beside its code: documentation, licences, drawings, terminals, reference results."""
