"""Systems of components and connections, as values."""
