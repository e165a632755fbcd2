"""The studies: scenarios, metrics, figures, tables, and the command line `flexsat`."""
