"""Time before the first tick and after the last one over the number of recorded signals.

`python tests/bench/start_up.py [SIGNALS...]`: 10,000 and 40,000 if none are given. The component is a compiled FMU with
so many scalar outputs, whose own cost is next to nothing; all of them are recorded in ten ticks. Each size is run in a
process of its own. Printed are processor times, which what else the machine does disturbs less than time on the clock,
and after the run that of reading its results again. Linear is a ratio of the times like that of the signals, or less:
the start of Python and of the packages, `program`, counts once. Nothing passes or fails here.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent))

ONE = """
from time import process_time
import sys
from pathlib import Path
from lockstep import load_system, read_signals, simulate
from lockstep.cli.run_options import with_processes
from lockstep.run.loop import Loop
from lockstep.ssp.step_times import Timing
import lockstep.simulation
program = process_time()
folder, fmu = Path(sys.argv[1]), Path(sys.argv[2])
marks = []
run = Loop.run
def marked(self, *rest):
    marks.append(process_time())
    run(self, *rest)
    marks.append(process_time())
Loop.run = marked
system = with_processes(load_system(fmu, Timing(period=1_000_000)), [], ["*"])
simulate(system, folder / "run", stop_time=0.01)
end = process_time()
signals = read_signals(folder / "run", [f"{system.name}.y[{k}]" for k in range(int(sys.argv[3]))])
signals[f"{system.name}.y"]
print(program, marks[0] - program, marks[1] - marks[0], end - marks[1], process_time() - end)
"""


def wide_outputs(folder: Path, width: int) -> Path:
    """Compile and pack an FMU with so many outputs and no inputs."""
    from fmus.c_fmu import compile_library, pack_fmu, quoted

    guid, library = "{5d2c1f0a-7d0e-4f5c-9a55-2a3d2f7b6c11}", folder / f"wide{width}.so"
    compile_library(library, [HERE / "wide.c"], defines=[quoted("GUID", guid), f"WIDTH={width}"], options=["-O2"])
    variables = "".join(
        f'<ScalarVariable name="y[{k}]" valueReference="{width + k}" causality="output"><Real/></ScalarVariable>'
        for k in range(width)
    )
    outputs = "".join(f'<Unknown index="{k + 1}"/>' for k in range(width))
    description = (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="2.0" modelName="wide" guid="{guid}">'
        f'<CoSimulation modelIdentifier="wide{width}"/><ModelVariables>{variables}</ModelVariables>'
        f"<ModelStructure><Outputs>{outputs}</Outputs></ModelStructure></fmiModelDescription>"
    )
    return pack_fmu(folder / f"wide{width}.fmu", description, library)


def main() -> None:
    """Print a table."""
    print("signals   program  before the first tick  ten ticks  after the last tick  reading   [s of processor time]")
    for width in [int(text) for text in sys.argv[1:]] or [10_000, 40_000]:
        with tempfile.TemporaryDirectory() as folder:
            fmu = wide_outputs(Path(folder), width)
            command = [sys.executable, "-c", ONE, folder, str(fmu), str(width)]
            found = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.split()
        program, before, ticks, after, reading = map(float, found)
        print(f"{width:7} {program:9.2f} {before:22.2f} {ticks:10.2f} {after:20.2f} {reading:8.2f}", flush=True)


if __name__ == "__main__":
    main()
