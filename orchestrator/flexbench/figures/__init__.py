"""Figures of the studies: each a function of results that returns a matplotlib figure, in a module named for it."""
