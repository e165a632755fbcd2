"""Each FMU in FMPy's `simulate_fmu`, compared with a sequence of FMPy's low-level calls."""

import pytest
from hosting import CONFIGURATIONS, Row, agreement, joined

STEPS = {"plant": 1_000_000, "sensors": 1_000_000, "controller": 5_000_000}  # [ns]


def compare(bench, configuration, component, steps=100):
    """Run both ways with the same moving inputs."""
    moving = bench.moving(component, configuration)
    setup = {"inputs": moving, "step": STEPS[component], "steps": steps, "times": "simulate_fmu"}
    expected = bench.low_level(component, configuration, **setup)
    own = {"fmu": str(bench.fmu(component, configuration)), "outputs": bench.outputs(component, configuration)}
    found = bench.run("run_fmpy.py", setup | own | {"way": "simulate_fmu"})
    return Row(
        kind=component,
        host="FMPy `simulate_fmu`",
        ran=f"{steps} steps of {STEPS[component] / 1e6:g} ms, inputs moving",
        agreement=agreement(expected, found),
        remark="against FMPy's low-level calls, flat names against structured ones",
    )


def rows(bench):
    """Compare, and say so in the table."""
    for component in STEPS:
        yield joined({configuration: compare(bench, configuration, component) for configuration in CONFIGURATIONS})


@pytest.mark.parametrize("component", STEPS)
@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_simulate_fmu_agrees_bitwise_with_low_level_calls(bench, configuration, component):
    assert compare(bench, configuration, component).agreement == "bitwise"
