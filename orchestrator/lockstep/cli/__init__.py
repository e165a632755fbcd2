"""The command line: programs and commands, options that commands share, and what `python -m lockstep` does."""
