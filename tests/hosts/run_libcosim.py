"""Run an SSP in libcosim and save what the outputs are after each base step, or after every so many."""

import json
import os
import sys
from pathlib import Path

import numpy as np
from hosting import save
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver


def main(given, saved):
    """Run what `given` says."""
    setup = json.loads(Path(given).read_text(encoding="utf-8"))
    every = setup.get("every", 1)
    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_ssp_file(ssp_path=setup["package"], step_size=setup["tick"])
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    slaves = {name: execution.slave_index_from_instance_name(name) for name in setup["references"]}
    for name, values in setup.get("parameters", {}).items():
        for parameter, value in values.items():
            reference = setup["parameter_references"][name][parameter]
            assert execution.real_initial_value(slaves[name], reference, value)
    # libcosim shows the outputs of a slave with a longer step only at the end of that step
    late = {name: setup.get("late", {}).get(name, 0) for name in slaves}
    columns = {name: [] for name in slaves}
    for tick in range(every - 1, setup["ticks"] + max(late.values()), every):
        assert execution.step(every)
        for name, slave in slaves.items():
            if 0 <= tick - late[name] < setup["ticks"]:
                references = list(setup["references"][name].values())
                columns[name].append(observer.last_real_values(slave_index=slave, variable_references=references))
    names = [f"{name}.{output}" for name in slaves for output in setup["references"][name]]
    save(saved, names, np.hstack([np.array(columns[name]) for name in slaves]))


if __name__ == "__main__":
    for given, saved in zip(sys.argv[1::2], sys.argv[2::2], strict=True):
        main(given, saved)
    sys.stdout.flush()
    os._exit(0)  # libcosim frees the FMUs after the interpreter is gone
