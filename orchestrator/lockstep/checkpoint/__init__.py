"""Save the state of a whole run, resume it after it was killed, and start other runs from it."""
