"""Close the loop in sofirpy: all components at one step, every value a step late."""

import sys

from loop import first_inputs, read, save
from sofirpy import simulate


def main(given, saved):
    """Run what `given` says."""
    loop = read(given)
    inputs = first_inputs(loop)
    connections = {name: [] for name in loop.fmus}
    for source, output, name, target in loop.connections:
        connections[name].append(
            {"parameter_name": target, "connect_to_system": source, "connect_to_external_parameter": output}
        )
    results = simulate(
        stop_time=loop.ticks * loop.step,
        step_size=loop.step,
        fmu_paths=loop.fmus,
        connections_config=connections,
        start_values={name: loop.values[name] | inputs[name] for name in loop.fmus},
        parameters_to_log=loop.outputs,
    )
    save(saved, loop, results[loop.columns].to_numpy()[1:])  # without the start values


if __name__ == "__main__":
    main(*sys.argv[1:])
