"""Close the loop in gemseo-fmu, by an MDA of Jacobi or of Gauss and Seidel, all components at one step."""

import numpy as np
from fmpy import read_model_description
from gemseo_fmu.disciplines._variables import RealVariable
from gemseo_fmu.disciplines.do_step_fmu_discipline import DoStepFMUDiscipline
from gemseo_fmu.disciplines.time_stepping_system import TimeSteppingSystem
from loop import first_inputs, read, run_each, save


class TypedDiscipline(DoStepFMUDiscipline):
    """A discipline that couples Booleans too, and sets parameters once, in the initialization.

    For FMI 2.0 gemseo-fmu supports Reals alone, and it sets all its inputs at every step, where a fixed parameter is
    refused.
    """

    def __init__(self, path, inputs, outputs, values, **settings):
        """Take the couplings of inputs and outputs by their names in the FMU, and values to initialize with."""
        variables = {v.name: v for v in read_model_description(path).modelVariables}
        reals = [[name for name in ports if variables[name].type == "Real"] for ports in (inputs, outputs)]
        super().__init__(
            path,
            input_names=reals[0],
            output_names=reals[1],
            variable_names={name: (inputs | outputs)[name] for names in reals for name in names},
            **settings,
        )
        for ports, grammar in ((inputs, self.io.input_grammar), (outputs, self.io.output_grammar)):
            for name, coupling in ports.items():
                if variables[name].type == "Boolean":
                    grammar.update_from_names([coupling])
                    reference = variables[name].valueReference
                    getter, setter = self.model.getBoolean, self._set_boolean
                    self._to_fmu_variables[coupling] = RealVariable(name, coupling, getter, setter, reference)
        enter = self.model.enterInitializationMode

        def enter_and_set():
            enter()
            for name, value in values.items():
                getattr(self.model, f"set{variables[name].type}")([variables[name].valueReference], [value])

        self.model.enterInitializationMode = enter_and_set

    def _set_boolean(self, references, values):
        self.model.setBoolean(references, [bool(value) for value in values])


def main(given, saved):
    """Run what `given` says."""
    loop = read(given)
    first = first_inputs(loop)
    end = (loop.ticks + 1) * loop.step  # a step later: the times are added up, and the last step would be cut
    disciplines = []
    for name, path in loop.fmus.items():
        inputs = {target: f"{source}:{output}" for source, output, to, target in loop.connections if to == name}
        connected = [output for source, output, *_ in loop.connections if source == name]
        outputs = {output: f"{name}:{output}" for output in [*connected, *loop.outputs[name]]}
        settings = {"time_step": loop.step, "final_time": end, "name": name}
        discipline = TypedDiscipline(path, inputs, outputs, loop.values[name], **settings)
        defaults = {inputs[target]: np.array([float(value)]) for target, value in first[name].items()}
        discipline.io.input_grammar.defaults.update(defaults)
        disciplines.append(discipline)
    system = TimeSteppingSystem(
        disciplines,
        end,
        loop.step,
        restart=False,
        do_step=True,
        mda_name=loop.options["mda"],
        mda_options=loop.options["mda_options"],
    )
    rows = []
    for _ in range(loop.ticks):
        found = system.execute()
        rows.append([found[f"{name}:{output}"][0] for name, outputs in loop.outputs.items() for output in outputs])
    save(saved, loop, rows)


if __name__ == "__main__":
    run_each(main)
