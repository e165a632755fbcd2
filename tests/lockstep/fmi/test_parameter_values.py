"""Values of parameters are checked against the declaration of their variable."""

import pytest

from lockstep import InputError
from lockstep.fmi.model_description import Variable
from lockstep.fmi.parameter_values import parse_value


def test_value_outside_its_declared_range_is_refused():
    variable = Variable(name="k", reference=0, type="Real", causality="parameter", minimum=0.0, maximum=1.0)
    assert parse_value("1", variable, "c.k") == 1.0
    with pytest.raises(InputError, match=r"c\.k: 2 is outside \[0\.0, 1\.0\], which the FMU declares"):
        parse_value(2, variable, "c.k")
