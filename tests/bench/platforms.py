"""CPU seconds and sizes of the libraries of native FMUs, by platform: `python tests/bench/platforms.py --fmus fmus`.

The sources are those in built FMUs. What FMUs have in common is compiled with the first of them.
"""

from __future__ import annotations

import argparse
import resource
import zipfile
from pathlib import Path

from flexsat.fmu.native.compile import compile_library
from flexsat.fmu.native.platforms import PLATFORMS

COMPONENTS = ("sensors", "plant", "controller")


def cpu() -> float:
    """Return the CPU seconds of all processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def sources(fmu: Path) -> dict[str, bytes]:
    """Return the C files and headers in an FMU."""
    with zipfile.ZipFile(fmu) as archive:
        names = [name for name in archive.namelist() if name.startswith("sources/") and name.endswith((".c", ".h"))]
        return {name.removeprefix("sources/"): archive.read(name) for name in names}


def main() -> None:
    """Compile all, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fmus", type=Path, default=Path("fmus"))
    parser.add_argument("--configuration", nargs="*", default=["centralised", "distributed"])
    options = parser.parse_args()
    targets = [target for platform in PLATFORMS.values() for target in platform.targets]
    print(f"{'CPU s, MB':24}" + "".join(f"{target or 'cc':>18}" for target in (None, *targets)))
    total = dict.fromkeys((None, *targets), 0.0)
    for configuration in options.configuration:
        for component in COMPONENTS:
            files = sources(options.fmus / configuration / "native" / f"{component}.fmu")
            row = ""
            for target in (None, *targets):
                before = cpu()
                size = len(compile_library(files, component, target)) / 1e6
                spent = cpu() - before
                total[target] += spent
                row += f"{spent:10.1f},{size:7.2f}"
            print(f"{configuration + ' ' + component:24}{row}", flush=True)
    print(f"{'all':24}" + "".join(f"{spent:10.1f}{'':8}" for spent in total.values()))


if __name__ == "__main__":
    main()
