"""Print the tables of hosts in Markdown: `python tests/hosts/table.py`. The tests assert what they say.

With arguments only those named: `agreement`, `delays`, `loops` and `costs` (some minutes).
"""

import importlib
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from hosting import Bench, build
from loops import Loop, lateness_rows, loop_head, loop_rows
from pypi.costs import cost_rows

FILES = (
    "test_simulate_fmu",
    "test_c_host",
    "test_container",
    "test_libcosim",
    "test_ecos",
    "test_native_fmus",
    "pypi.test_packages",
)
TABLES = ("agreement", "delays", "loops", "costs")
# the slew is flown from 5 to 106 s; what simulate_ssp stirs up at first has decayed after 40 s of fine pointing
LOOPS = [
    Loop(configuration=configuration, scenario=scenario, duration=duration, since=since)
    for scenario, duration, since in (("fine_pointing", 100.0, 50.0), ("slew", 160.0, 120.0))
    for configuration in ("centralised", "distributed")
]


def agreement(bench):
    """Print a line for each FMU kind in each host."""
    print("| FMU kind | host | what ran | agreement | remark |\n|---|---|---|---|---|")
    for name in FILES:
        host = importlib.import_module(name)
        missing = getattr(host, "missing", str)()
        if missing:
            print(f"| | {name.removeprefix('test_')} | | not run | {missing} |")
            continue
        for row in host.rows(bench):
            print(f"| {row.kind} | {row.host} | {row.ran} | {row.agreement} | {row.remark} |", flush=True)


def delays(bench):
    """Print the delays of each master."""
    print("\n".join(lateness_rows(bench)), flush=True)


def loops(bench):
    """Print the metrics of the closed loops in each master."""
    print("\n".join(loop_head()), flush=True)
    for loop in LOOPS:
        for row in loop_rows(bench, loop):
            print(row, flush=True)


def costs(bench):
    """Print what the ways of hosts to step the loop cost."""
    for row in cost_rows(bench):
        print(row, flush=True)


def main(names):
    """Print the tables asked for."""
    unknown = [name for name in names if name not in TABLES]
    if unknown:
        sys.exit(f"{unknown[0]}: no such table; there are {', '.join(TABLES)}")
    with tempfile.TemporaryDirectory(prefix="flexsat_hosts_") as folder:
        work = Path(folder) / "work"
        work.mkdir()
        build(Path(folder) / "fmus")
        bench = Bench(Path(folder) / "fmus", work)
        for name in names or TABLES:
            globals()[name](bench)
            print()


if __name__ == "__main__":
    main(sys.argv[1:])
