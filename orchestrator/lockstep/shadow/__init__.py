"""Run a second FMU in shadow of a component, open loop, and switch over to it without a jump."""
