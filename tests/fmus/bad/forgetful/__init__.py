"""A component with a defect; `flexsat.forgetful` to those who add the folder above to `flexsat.__path__`."""
