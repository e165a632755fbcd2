"""Files of an FMU other than its code: documentation, licences, drawings, terminals, reference results."""
