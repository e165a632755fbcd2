"""Units of flexsat's ports against the table of the master: one meaning for a name."""

import pytest

from flexsat.ports.units import BASE_UNITS
from flexsat.ports.units import UNITS as PORT_UNITS
from lockstep.system.unit_table import meanings
from lockstep.system.units import BASES


def test_base_units_stand_in_the_same_order():
    assert BASE_UNITS == BASES


@pytest.mark.parametrize("name", [name for name, unit in PORT_UNITS.items() if unit.exponents is not None])
def test_port_unit_means_the_same_to_the_master(name):
    unit = PORT_UNITS[name]
    exponents = tuple(unit.exponents.get(base, 0) for base in BASES)

    assert (1.0, exponents) in [(known.factor, known.exponents) for known in meanings(name)]


def test_display_units_scale_as_the_master_converts():
    for unit in PORT_UNITS.values():
        for name, factor in unit.display.items():
            assert meanings(name)[0].factor * factor == pytest.approx(1.0, rel=1e-15)
