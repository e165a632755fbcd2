"""An instance under check: values of every type, the record of the last call, and failures as RunError."""

import zipfile
from dataclasses import replace

import numpy as np
import pytest

from lockstep.check.dynamic.checked_instance import CheckedInstance
from lockstep.check.dynamic.experiment import read_experiment, read_other_experiment
from lockstep.check.dynamic.trajectory import difference, output_names
from lockstep.errors import EndOfSimulation, RunError
from lockstep.fmi.model_description import read_description
from lockstep.fmi.slave import ERROR
from lockstep.processes.last_call import last_call_in, read_last_call
from lockstep.system.component import Component


@pytest.fixture
def opened(reference_fmu, tmp_path):
    """Return a function that instantiates a reference FMU of a version; instances are closed at the end."""
    instances = []

    def open_fmu(model, version, **starts):
        source = reference_fmu(model, version)
        with zipfile.ZipFile(source) as archive:
            archive.extractall(tmp_path / model)
        description = read_description(Component(name="part", source=source, period=1))
        folder = tmp_path / model
        experiment = read_experiment(folder) if version == "2.0" else read_other_experiment(folder, description)
        given = tuple(("Integer", description.variables[name].reference, value) for name, value in starts.items())
        experiment = replace(experiment, starts=given)
        last_call, variables = last_call_in(tmp_path / "last_call"), description.variables.values()
        instances.append(CheckedInstance(experiment, folder, last_call, variables=variables))
        return instances[-1]

    yield open_fmu
    for instance in instances:
        instance.close()


@pytest.mark.parametrize("version", ["1.0", "2.0", "3.0"])
def test_values_of_every_type_reach_the_output_of_their_name(opened, version):
    instance = opened("feedthrough", version)
    instance.initialise()
    values = {}
    for port_call in instance.write:
        count = np.arange(len(port_call.ports))
        row = count % 2 if port_call.scalar == "Boolean" else count + 2
        values |= {port.name.replace("_in", "_out"): value for port, value in zip(port_call.ports, row, strict=True)}
    instance.put([[values[port.name.replace("_in", "_out")] for port in call.ports] for call in instance.write])
    instance.step(0.0, instance.experiment.step)
    reals, integers, _ = instance.row()

    numbers = dict(zip(output_names(instance.experiment), [*reals, *integers], strict=False))
    assert numbers == values


def test_the_stimulus_of_each_phase_is_made_once_and_is_its_own(opened):
    instance = opened("feedthrough", "2.0")
    for phase in (0, 11, 0):
        for table, port_call in zip(instance.stimuli(phase), instance.write, strict=True):
            assert np.array_equal(table, instance.experiment.stimulus(port_call.scalar, phase))
    assert instance.stimuli(11) is instance.stimuli(11)
    first, other = instance.stimuli()[0], instance.stimuli(11)[0]
    assert not np.array_equal(first, other)
    with pytest.raises(ValueError, match="read-only"):
        first[:] = 0.0


@pytest.mark.parametrize(("version", "prefix"), [("1.0", "fmi"), ("2.0", "fmi2"), ("3.0", "fmi3")])
def test_failure_names_call_status_time_and_message(opened, version, prefix, tmp_path):
    instance = opened("stair", version, mode=4, at=3)  # its third step fails
    instance.initialise()
    time, step = instance.experiment.time, instance.experiment.step
    for k in range(2):
        instance.step(time(k), step)
    with pytest.raises(RunError) as caught:
        instance.step(time(2), step)

    error = f"{prefix}DoStep returned {prefix}Error at t = {time(2):.9g} s: the stair has a broken step"
    assert str(caught.value) == error
    assert read_last_call(tmp_path / "last_call") == ""  # every call has returned


@pytest.mark.parametrize("version", ["1.0", "2.0", "3.0"])
def test_a_reset_instance_makes_the_same_run_again(opened, version):
    instance = opened("integrator", version)
    runs = []
    for _ in range(2):
        instance.initialise()
        runs.append(instance.run(0, 5))
        instance.reset()

    assert runs[0].reals[:, 0].tolist() != [runs[0].reals[0, 0]] * 5
    assert difference(runs[1], runs[0], instance.experiment) == ""


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_regular_end_is_no_failure(opened, version):
    instance = opened("stair", version, last=3)
    instance.initialise()
    instance.run(0, 3)
    with pytest.raises(EndOfSimulation) as caught:
        instance.step(instance.experiment.time(3), instance.experiment.step)

    assert not caught.value.complete
    instance.close()
    assert instance.worst < ERROR
