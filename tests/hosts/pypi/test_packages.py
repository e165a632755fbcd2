"""The closed loop in hosts from PyPI, each compared with lockstep in that host's way to step it.

What a user of each has to know stands with its row in `packages.py`.
"""

import numpy as np
import pytest
from hosting import Row, agreement
from pypi.packages import OTHERS, PACKAGES, SCHEMES, TICKS, references

CONFIGURATIONS = ("centralised", "distributed", "centralised/native", "distributed/native")


TESTED = ("centralised", "centralised/native")


@pytest.fixture(scope="module")
def expected(bench):
    """Return the rows of lockstep by configuration, stepped as each host does."""
    return {configuration: references(bench, configuration) for configuration in TESTED}


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
        found = package.run(bench, CONFIGURATIONS)
        agreements = [agreement(ways[c][package.scheme], found[c]) for c in CONFIGURATIONS]
        yield Row(
            kind="three FMUs in a closed loop",
            host=package.name,
            ran=f"{', '.join(CONFIGURATIONS)}: fine pointing, {TICKS} steps of 5 ms; {SCHEMES[package.scheme].text}",
            agreement=", ".join(dict.fromkeys(agreements)),
            remark=package.remark,
        )


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name.partition(",")[0])
def test_loop_agrees_bitwise_with_lockstep_in_the_way_of_the_host(bench, expected, package):
    if package.missing:
        pytest.skip(package.missing)

    found = package.run(bench, TESTED)

    agreements = {c: agreement(expected[c][package.scheme], found[c]) for c in TESTED}
    assert agreements == dict.fromkeys(TESTED, "bitwise")


@pytest.mark.parametrize("configuration", TESTED)
def test_each_way_differs_from_the_others(expected, configuration):
    ways = expected[configuration]
    for name, way in ways.items():
        assert not any(np.array_equal(way.values, other.values) for others, other in ways.items() if others != name)
