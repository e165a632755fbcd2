"""Time of a step of the exported controller: `python tests/bench/embedded_steps.py --fmus FMUS [--compiler cc]`.

Both layouts, doubles and floats, in a loop with a rigid spacecraft: steady steps, and the step that plans a slew, with
each guidance. Size of code, of constants and of memory are printed with it.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from flexbench.loop.exported_controller import export_controller
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.fmu.embedded.export import HEADER
from flexsat.fmu.embedded.header import PRECISIONS
from fmus.native.exported import constant, target_sources

HERE = Path(__file__).parent
OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off")


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmus", type=Path, default=Path("fmus"), help="folder that `flexsat build` filled")
    parser.add_argument("--compiler", default="cc")
    chosen = parser.parse_args()
    for name, precision in product(CONFIGURATIONS, PRECISIONS):
        with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as temporary:
            folder = Path(temporary)
            export_controller(chosen.fmus, name, "robust", precision, folder)
            header = (folder / HEADER).read_bytes()
            compiler = [chosen.compiler, *OPTIONS]
            subprocess.run([*compiler, "-c", *target_sources(folder)], cwd=folder, check=True)
            command = [*compiler, "-I.", HERE / "embedded_steps.c", "rigid_spacecraft.c", *folder.glob("*.o")]
            subprocess.run([*command, "-lm", "-o", "steps"], cwd=folder, check=True)
            objects = sorted(path.name for path in folder.glob("*.o"))
            sizes = subprocess.run(["size", "-t", *objects], cwd=folder, check=True, capture_output=True, text=True)
            rows = {words[-1]: words for words in map(str.split, sizes.stdout.splitlines())}
            total, data = (int(rows[what][0]) for what in ("(TOTALS)", "data.o"))
            print(f"{name}, {precision}: {(total - data) / 1e3:.0f} kB of code, {data / 1e3:.0f} kB of matrices, "
                  f"{constant(header, 'FLEXSAT_MEMORY_SIZE') / 1e3:.0f} kB of memory at most, "
                  f"{constant(header, 'FLEXSAT_STATE_SIZE') / 1e3:.1f} kB of state")  # fmt: skip
            print(
                subprocess.run(["./steps"], cwd=folder, check=True, capture_output=True, text=True).stdout, flush=True
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
