"""Lists of numbers as C: exact, in lines that are not too long."""

import re

import numpy as np
import pytest

from flexsat.fmu.native.c_text import WIDTH, double_text, wrapped, wrapped_doubles


def test_doubles_in_lines_are_exact_and_as_each_alone():
    random = np.random.default_rng(1)
    bits = np.frombuffer(random.bytes(8 * 3000), np.float64)  # all exponents, subnormal ones too
    few = [0.0, -0.0, 1.0, -2.5, 16.0, 1e308, 5e-324, -5e-324, 1e-310, 2.0**-1022, 0.1, 2.0**-10 + 2.0**-50]
    values = np.concatenate([few, bits[np.isfinite(bits)], random.integers(-9, 9, 500) / 4.0, np.zeros(200)])

    lines = list(wrapped_doubles(values))

    assert lines == list(wrapped([double_text(value) for value in values.tolist()]))
    assert max(map(len, lines)) <= WIDTH
    words = re.findall(r"[^ ,]+", " ".join(lines))
    read = np.array([float.fromhex(word) for word in words])
    assert read.tobytes() == values.tobytes()


def test_one_double_is_one_line():
    assert list(wrapped_doubles(np.array([[-1.5]]))) == ["    -0x1.8p0,"]


@pytest.mark.parametrize("values", [[], [1.0, np.nan], [-np.inf]])
def test_what_is_no_c_constant_is_refused(values):
    with pytest.raises(ValueError, match="must be finite, and at least one"):
        wrapped_doubles(np.array(values))
