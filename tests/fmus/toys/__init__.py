"""Toy components; `flexsat.toys` to those who add the folder above to `flexsat.__path__`."""
