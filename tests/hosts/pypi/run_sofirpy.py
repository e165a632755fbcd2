"""Close the loop in sofirpy: all components at one step, every value a step late.

sofirpy sets the inputs of the next step one connection after the other, and logs after that. Accelerations change at
once with the torque, so the connections of the sensors come first, and what is passed on is logged as it arrives.
"""

from loop import first_inputs, read, run_each, save
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
    arrived = {f"{source}.{output}": (name, target) for source, output, name, target in loop.connections}
    logged = [arrived.get(column, tuple(column.split(".", 1))) for column in loop.columns]
    results = simulate(
        stop_time=loop.ticks * loop.step,
        step_size=loop.step,
        fmu_paths=loop.fmus,
        connections_config=connections,
        start_values={name: loop.values[name] | inputs[name] for name in loop.fmus},
        parameters_to_log={name: [port for owner, port in logged if owner == name] for name in loop.fmus},
    )
    columns = [f"{owner}.{port}" for owner, port in logged]
    save(saved, loop, results[columns].to_numpy()[1:])  # without the start values


if __name__ == "__main__":
    run_each(main)
