"""One run: values exchanged, components initialised and stepped."""
