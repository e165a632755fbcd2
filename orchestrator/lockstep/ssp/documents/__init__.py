"""Documents of SSP as XML: found, parsed, amended and validated."""
