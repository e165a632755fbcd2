"""Each FMU in FMPy's `simulate_fmu`, against our own sequence of FMPy's low-level calls."""

import pytest
from hosting import Row, agreement

STEPS = {"plant": 1_000_000, "sensors": 1_000_000, "controller": 5_000_000}  # [ns]


def compare(bench, configuration, component, steps=100):
    """Run both ways with the same moving inputs."""
    fmu = bench.fmu(component, configuration)
    variables = bench.description(fmu).modelVariables
    # a command that moves is refused once a slew has begun
    moving = [
        (v.valueReference, float(v.start))
        for v in variables
        if v.causality == "input" and v.type == "Real" and not v.name.startswith("command.")
    ]
    setup = {
        "fmu": str(fmu),
        "inputs": moving,
        "outputs": bench.outputs(component, configuration),
        "step": STEPS[component],
        "steps": steps,
        "times": "simulate_fmu",
    }
    low, simulated = (bench.run("run_fmpy.py", setup | {"way": way}) for way in ("low-level", "simulate_fmu"))
    return Row(
        kind=f"{component}, {configuration}",
        host="FMPy `simulate_fmu`",
        ran=f"{steps} steps of {STEPS[component] / 1e6:g} ms, {len(moving)} moving inputs, {len(low.names)} outputs",
        agreement=agreement(low, simulated),
        remark="against FMPy's low-level calls",
    )


def rows(bench):
    """Compare, and say so in the table."""
    for configuration in bench.configurations:
        for component in STEPS:
            yield compare(bench, configuration, component)


@pytest.mark.parametrize("component", STEPS)
@pytest.mark.parametrize("configuration", ["centralised", "distributed"])
def test_simulate_fmu_agrees_bitwise_with_low_level_calls(bench, configuration, component):
    assert compare(bench, configuration, component).agreement == "bitwise"
