"""The command line `flexsat`: the parser and one module a command."""
