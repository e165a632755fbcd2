"""Make the robust design of both layouts on import: what is copied from a process that imported this has them."""

from flexsat.description.built_in import CONFIGURATIONS
from flexsat.design.chain import build_designs

for name in CONFIGURATIONS:
    assert build_designs(name).corrected
