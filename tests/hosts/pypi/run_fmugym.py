"""Close the loop in FMUGym: the environment is a container of sensors and plant, the agent is the controller.

The container is made by fmu-manipulation-toolbox, as FMUGym takes one FMU, sets Reals alone and no start values.
"""

import tempfile
from pathlib import Path

import numpy as np
import toolbox
from fmugym import FMUGym, FMUGymConfig, VarSpace
from loop import Component, first_inputs, read, run_each, save


class Spacecraft(FMUGym):
    """Sensors and plant: an action is one torque a wheel, held over 5 ms."""

    def __init__(self, config, measurements):
        self.measurements = measurements
        self.variables = {}
        super().__init__(config)
        self.variables = {v.name: v for v in self.fmu_description.modelVariables}

    def compute_reward(self, obs, info):  # noqa: ARG002
        """Return a reward, which the loop does not use."""
        return -float(np.square(obs).sum())

    def _noisy_init(self):
        return {}  # that of FMUGym reads an attribute that it never sets

    def _get_info(self):
        """Return the measurements in double precision and by type: an observation is of 32-bit Reals."""
        getters = {"Real": self.fmu.getReal, "Boolean": self.fmu.getBoolean}
        found = {name: self.variables[name] for name in self.measurements}
        return {name: getters[v.type]([v.valueReference])[0] for name, v in found.items()}


def main(given, saved):
    """Run what `given` says."""
    loop = read(given)
    first = first_inputs(loop)
    for name, inputs in first.items():
        loop.values[name].update(inputs)
    wires = [wire for wire in loop.connections if wire[2] == "controller"]
    commands = {
        f"in.{to}.{target}": output for source, output, to, target in loop.connections if source == "controller"
    }
    measured = {target: f"out.{source}.{output}" for source, output, _, target in wires}
    shown = [f"out.{name}.{output}" for name in toolbox.FAST for output in loop.outputs[name]]
    inputs, outputs = VarSpace("inputs"), VarSpace("outputs")
    for name in commands:
        inputs.add_var_box(name, -4.4, 4.4)
    for name in shown:
        outputs.add_var_box(name, -np.inf, np.inf)
    with tempfile.TemporaryDirectory() as folder:
        config = FMUGymConfig(
            fmu_path=str(toolbox.build(toolbox.spacecraft(loop), loop, Path(folder))),
            stop_time=(loop.ticks + 1) * loop.step,
            # both equal: FMUGym adds up its time, and of several steps an action would make one more or less
            sim_step_size=loop.step,
            action_step_size=loop.step,
            inputs=inputs,
            outputs=outputs,
            random_vars=VarSpace("none"),
        )
        environment = Spacecraft(config, list(dict.fromkeys([*measured.values(), *shown])))
        agent = Component(loop.fmus["controller"])
        agent.initialize(loop.values["controller"])
        _, info = environment.reset(seed=0)
        rows = []
        for tick in range(loop.ticks):
            agent.set({target: info[name] for target, name in measured.items()})
            agent.fmu.doStep(tick * loop.step, loop.step)
            torque = agent.get(list(commands.values()))
            action = np.array([torque[commands[name]] for name in environment.input_dict])
            _, _, _, _, info = environment.step(action)
            found = info | {f"out.controller.{k}": v for k, v in agent.get(loop.outputs["controller"]).items()}
            rows.append([found[f"out.{column}"] for column in loop.columns])
        agent.close()
        environment.close()
    save(saved, loop, rows)


if __name__ == "__main__":
    run_each(main)
