"""Build toy components, and run scripts against them in fresh processes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

TOYS = Path(__file__).parent
_BUILD = """
import sys
from pathlib import Path
import flexsat
flexsat.__path__.append(sys.argv[1])
from flexsat.fmu.export import build_fmu
built = build_fmu("flexsat.toys.counter:Counter", Path(sys.argv[2]), {"model.npz": b"numbers"}, sys.argv[3])
print(built.guid, built.sha256)
"""


def python(script, *arguments, check=True):
    """Run a script in a fresh process and return what it printed; a crash of the process fails the test."""
    done = subprocess.run(
        [
            sys.executable,
            "-W",
            "error",
            "-c",
            f"import sys; sys.path.append({str(TOYS)!r})\n{script}",
            *map(str, arguments),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    if check:
        assert done.returncode == 0, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout if check else done


def build(path, packages=TOYS.parent, name="toy"):
    """Build the counter in a fresh process; return its GUID and SHA-256."""
    return tuple(python(_BUILD, packages, path, name).split())


def copy_toys(packages, *replacements):
    """Copy the toys to `packages`/toys, with each (old, new) text of their sources replaced; return `packages`."""
    (packages / "toys").mkdir(parents=True)
    for source in TOYS.glob("*.py"):
        text = source.read_text(encoding="utf-8")
        for old, new in replacements:
            text = text.replace(old, new)
        (packages / "toys" / source.name).write_text(text, encoding="utf-8")
    return packages
