"""Studies: values in, values out. They draw nothing."""
