"""Close the loop in a container of fmu-manipulation-toolbox, run by FMPy."""

import tempfile
from pathlib import Path

import toolbox
from loop import Component, first_inputs, read, run_each, save


def main(given, saved):
    """Run what `given` says."""
    loop = read(given)
    for name, inputs in first_inputs(loop).items():
        loop.values[name].update(inputs)  # as start values: in a loop the toolbox propagates nothing before the start
    if loop.options["nested"]:
        description, prefix = toolbox.nested(loop), "all"
    else:
        step = loop.options.get("container_step", loop.step)
        description, prefix = toolbox.plain(loop, loop.options["sequential"], step), "out"
    with tempfile.TemporaryDirectory() as folder:
        container = Component(str(toolbox.build(description, loop, Path(folder))))
        container.initialize({})
        names, rows = [f"{prefix}.{column}" for column in loop.columns], []
        for tick in range(loop.ticks):
            container.fmu.doStep(tick * loop.step, loop.step)
            rows.append(list(container.get(names).values()))
        container.close()
    save(saved, loop, rows)


if __name__ == "__main__":
    run_each(main)
