"""Growth of resident memory: a leak continues, a buffer fills once."""

import numpy as np
import pytest

from lockstep.check.dynamic.probes_load import memory_result

COUNTS = np.arange(0, 100_001, 2500)


@pytest.mark.parametrize(
    ("grown", "status"),
    [
        (np.where(COUNTS > 0, 30.0, 0.0), "pass"),  # at start only
        (COUNTS * 1e-5, "pass"),  # 0.8 MB after the warm-up: what an allocator may do
        (COUNTS * 2e-5, "error"),  # 21 bytes a step
        (np.minimum(COUNTS, 50_000) * 1e-4, "info"),
    ],
)
def test_growth_is_judged_after_the_warm_up(grown: np.ndarray, status: str) -> None:
    found = memory_result(100.0 + grown, COUNTS, "")

    assert found.status == status, found
    assert "100,000 steps" in found.message


def test_leak_is_reported_in_bytes_per_step() -> None:
    found = memory_result(100.0 + COUNTS * 2**-20 * 64.0, COUNTS, "")

    assert found.numbers["growth [B/step]"] == pytest.approx(64.0)
    assert "64 bytes a step" in found.message
