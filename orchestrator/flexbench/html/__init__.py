"""HTML documents made of blocks."""
