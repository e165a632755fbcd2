"""The closed loop in hosts from PyPI, each compared with lockstep in that host's way to step it.

What a user of each has to know stands with its row in `packages.py`.
"""

import numpy as np
import pytest
from hosting import Row, agreement
from pypi.packages import OTHERS, PACKAGES, SCHEMES, TICKS, references

CONFIGURATIONS = ("centralised", "distributed", "centralised/native", "distributed/native")


@pytest.fixture(scope="module", params=["centralised", "centralised/native"])
def configuration(request):
    """Return a configuration that hosts simulate."""
    return request.param


@pytest.fixture(scope="module")
def expected(bench, configuration):
    """Return the rows of lockstep, stepped as each host does."""
    return references(bench, configuration)


def rows(bench):
    """Compare, and say so in the table."""
    ways = {configuration: references(bench, configuration) for configuration in CONFIGURATIONS}
    for package in (*PACKAGES, *OTHERS):
        if package.missing:
            yield Row(
                kind="three FMUs in a closed loop",
                host=package.name,
                ran="not run",
                agreement="",
                remark=package.missing,
            )
            continue
        found = {configuration: package.run(bench, configuration) for configuration in CONFIGURATIONS}
        agreements = [agreement(ways[c][package.scheme], found[c]) for c in CONFIGURATIONS]
        yield Row(
            kind="three FMUs in a closed loop",
            host=package.name,
            ran=f"{', '.join(CONFIGURATIONS)}: fine pointing, {TICKS} steps of 5 ms; {SCHEMES[package.scheme].text}",
            agreement=", ".join(dict.fromkeys(agreements)),
            remark=package.remark,
        )


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name.partition(",")[0])
def test_loop_agrees_bitwise_with_lockstep_in_the_way_of_the_host(bench, configuration, expected, package):
    if package.missing:
        pytest.skip(package.missing)

    found = package.run(bench, configuration)

    assert agreement(expected[package.scheme], found) == "bitwise"


def test_each_way_differs_from_the_others(expected):
    for name, way in expected.items():
        assert not any(np.array_equal(way.values, other.values) for others, other in expected.items() if others != name)
