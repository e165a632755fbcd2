"""The command line `flexsat`: the program and one module a command."""
