"""All three components as one FMU, made with FMPy's `container_fmu`, that then runs alone.

The container knows one rate, so all three step every 5 ms, the sensors by their parameter `step_size`. It steps
them all, then transfers all values: with one tick of delay on every connection lockstep must give the same bits.
"""

import shutil

import pytest
import test_c_host as c_host
from container import build_container
from hosting import COMPONENTS, Row, agreement

from lockstep import load_system
from lockstep.fmi.description_corrections import validation_problems

STEP = 5_000_000  # [ns]
ENDS = (("plant", "sensors"), ("sensors", "plant"), ("sensors", "controller"), ("controller", "plant"))


def alone(bench):
    """Return the container in a folder of its own; what it was made of was elsewhere, and is gone."""
    folder = bench.work / "container alone"
    fmu = folder / "closed_loop.fmu"
    if not fmu.exists():
        parts, made = bench.path("parts"), bench.path("made")
        shutil.copytree(bench.folder / "distributed", parts)
        built = build_container(load_system(parts / "fine_pointing.ssd"), STEP / 1e9, made)
        folder.mkdir()
        shutil.copy(built, fmu)
        shutil.rmtree(parts)
        shutil.rmtree(made)
    return fmu


def outputs(bench):
    """Return the container's value references of the real outputs by name."""
    references = {v.name: v.valueReference for v in bench.description(alone(bench)).modelVariables}
    names = [f"{component}.{name}" for component in COMPONENTS for name in bench.outputs(component)]
    return {name: references[name] for name in names}


def run(bench, steps, way):
    """Run it in FMPy."""
    setup = {"fmu": str(alone(bench)), "inputs": [], "outputs": outputs(bench), "step": STEP, "steps": steps}
    return bench.run("run_fmpy.py", setup | {"way": way, "times": "integer"})


def reference(bench, steps, others=None):
    """Run lockstep at one rate for all, with a tick of delay on every connection, or the delays given."""
    return bench.reference(steps, dict.fromkeys(ENDS, 1) | (others or {}), period=STEP)


def rows(bench):
    """Compare, and say so in the table."""
    steps = 100
    hosts = {
        "FMPy, low-level calls": lambda: run(bench, steps, "low-level"),
        "FMPy `simulate_fmu`": lambda: run(bench, steps, "simulate_fmu"),
    }
    if not c_host.missing():
        hosts["C program, no Python"] = lambda: run_in_c(bench, steps)
    for host, result in hosts.items():
        found = result()
        yield Row(
            kind="container of the three",
            host=host,
            ran=f"fine pointing, {steps} steps of 5 ms, {len(found.names)} outputs",
            agreement=agreement(reference(bench, steps), found),
            remark="one rate for all; against lockstep with its delays (1 step each)",
        )


def run_in_c(bench, steps):
    """Run it in a C program."""
    lines = [f"run {steps} {STEP}", "stateless", f"{c_host.unpacked(bench, alone(bench))} 1"]
    names = outputs(bench)
    lines += [f"watch {reference}" for reference in names.values()]
    return c_host.trajectory(c_host.call(bench, lines), list(names))


@pytest.mark.parametrize("way", ["low-level", "simulate_fmu"])
def test_the_container_agrees_bitwise_with_our_master(bench, way):
    assert agreement(reference(bench, 100), run(bench, 100, way)) == "bitwise"


@c_host.pytestmark
def test_the_container_runs_in_a_program_without_python(bench):
    assert agreement(reference(bench, 100), run_in_c(bench, 100)) == "bitwise"


def test_each_of_its_delays_matters(bench, native):
    found = run(bench, 20, "low-level")
    late = dict.fromkeys(ENDS, 1)
    # with native FMUs, as they take a fraction of the time: they agree with those in Python to rounding
    cases = [late, *(late | {ends: 2} for ends in ENDS)]
    same, *others = native.under_delays(20, cases, period=STEP, configuration="distributed/native")
    assert float(agreement(same, found)) < 1e-10
    assert [ends for ends, other in zip(ENDS, others, strict=True) if float(agreement(other, found)) < 1e-3] == []


def test_it_is_a_valid_fmu(bench):
    assert validation_problems(alone(bench)) == []
