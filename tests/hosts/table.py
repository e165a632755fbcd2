"""Print the table of hosts in Markdown: `python tests/hosts/table.py`. The tests assert what it says."""

import importlib
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from hosting import Bench, build

FILES = ("test_simulate_fmu", "test_c_host", "test_container", "test_libcosim", "test_ecos")


def main():
    """Run every host and print a line for each FMU kind in it."""
    print("| FMU kind | host | what ran | agreement | remark |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="flexsat_hosts_") as folder:
        work = Path(folder) / "work"
        work.mkdir()
        build(Path(folder) / "fmus")
        bench = Bench(Path(folder) / "fmus", work)
        for name in FILES:
            host = importlib.import_module(name)
            missing = getattr(host, "missing", str)()
            if missing:
                print(f"| | {name.removeprefix('test_')} | | not run | {missing} |")
                continue
            for row in host.rows(bench):
                print(f"| {row.kind} | {row.host} | {row.ran} | {row.agreement} | {row.remark} |", flush=True)


if __name__ == "__main__":
    main()
