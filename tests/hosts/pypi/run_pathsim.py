"""Close the loop in pathsim-fmi, each component at its own rate.

Blocks whose events fall on one time are stepped in the order in which the simulation got them, and the outputs of
each are passed on before the next steps: sensors, controller, plant is the order of a tick.
"""

from unittest.mock import patch

import numpy as np
import pathsim_fmi.blocks
from fmpy.fmi1 import FMICallException
from loop import first_inputs, read, run_each, save
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope


class TypedWrapper(pathsim_fmi.blocks.FMUWrapper):
    """Sets and reads each port by its own type; that of pathsim-fmi calls for Reals alone."""

    def set_inputs_from_array(self, values):
        """Set all inputs."""
        for name, value in zip(self.input_refs, values, strict=True):
            self.set_variable(name, value)

    def get_outputs_as_array(self):
        """Return all outputs."""
        getters = {"Real": self.fmu.getReal, "Boolean": self.fmu.getBoolean}
        return np.array([getters[self.variable_map[name].type]([vr])[0] for name, vr in self.output_refs.items()])


def assert_refused(path):
    """Step a controller as pathsim-fmi does by itself: its Booleans set as Reals are an error, not another input."""
    block = pathsim_fmi.CoSimulationFMU(path, "plain", {}, 5e-3)
    try:
        block.fmu_wrapper.set_inputs_from_array(block.inputs.to_array())
    except FMICallException:
        return
    raise AssertionError(f"{path} takes Booleans that are set as Reals")


def main(given, saved):
    """Run what `given` says."""
    loop = read(given)
    first = first_inputs(loop)
    assert_refused(loop.fmus["controller"])
    periods = loop.options["periods"]
    with patch.object(pathsim_fmi.blocks, "FMUWrapper", TypedWrapper):
        blocks = {
            name: pathsim_fmi.CoSimulationFMU(path, name, loop.values[name] | first[name], periods[name])
            for name, path in loop.fmus.items()
        }
    others, connections = [], [Connection(blocks[a][output], blocks[b][to]) for a, output, b, to in loop.connections]
    for name, block in blocks.items():
        for port, value in loop.values[name].items():  # what is not connected would be set to 0 at every step
            if value and port in block.fmu_wrapper.input_refs:
                others.append(Constant(float(value)))
                connections.append(Connection(others[-1][0], block[port]))
    scopes = {name: Scope() for name in loop.outputs}
    for name, outputs in loop.outputs.items():
        connections += [Connection(blocks[name][output], scopes[name][i]) for i, output in enumerate(outputs)]
    step = min(periods.values())
    simulation = Simulation([*blocks.values(), *scopes.values(), *others], connections, dt=step, log=False)
    every = round(loop.step / step)
    simulation.run((every * loop.ticks - 1) * step, adaptive=False)  # the first step of all is made at time 0
    save(saved, loop, np.vstack([scopes[name].read()[1] for name in loop.outputs]).T[every - 1 :: every])


if __name__ == "__main__":
    run_each(main)
