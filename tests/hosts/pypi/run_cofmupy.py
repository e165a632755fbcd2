"""Close the loop in CoFMuPy, in its way of Jacobi or of Gauss and Seidel, all components at one step."""

import cofmupy.wrappers
from cofmupy import Coordinator
from loop import first_inputs, read, run_each, save


class TypedHandler(cofmupy.wrappers.Fmu2Handler):
    """Sets and reads each variable by its own type, parameters in the initialization: CoFMuPy calls for Reals alone."""

    def _set_variable(self, name, value):
        variable = self.var_name2attr[name]
        getattr(self.fmu, f"set{variable.type}")([variable.valueReference], value)

    def step(self, current_time, step_size, input_dict):
        """Set the inputs, step, and return the outputs."""
        self.set_variables(input_dict)
        self.fmu.doStep(currentCommunicationPoint=current_time, communicationStepSize=step_size)
        return self.get_variables(self.output_var_names)


def main(given, saved):
    """Run what `given` says."""
    loop = read(given)
    inputs = first_inputs(loop)
    cofmupy.wrappers.Fmu2Handler = TypedHandler
    coordinator = Coordinator()
    coordinator.start(
        {
            "cosim_method": loop.options["method"],
            "iterative": False,
            "fmus": [
                {"id": name, "path": path, "initialization": loop.values[name] | inputs[name]}
                for name, path in loop.fmus.items()
            ],
            "connections": [
                {"source": {"id": source, "variable": output}, "target": {"id": name, "variable": target}}
                for source, output, name, target in loop.connections
            ],
        }
    )
    for _ in range(loop.ticks):
        coordinator.do_step(loop.step)
    results = coordinator.get_results()
    columns = [results[name, output] for name, outputs in loop.outputs.items() for output in outputs]
    save(saved, loop, list(zip(*columns, strict=True)))


if __name__ == "__main__":
    run_each(main)
