"""Programs in a process of their own: pipes that close, and modules that the help does not need."""

import os
import subprocess
import sys

BUFFERED = os.environ | {"PYTHONUNBUFFERED": ""}
TOY = """
import sys, types
from lockstep.cli.command import command
from lockstep.cli.program import CommandGroup

@command("talk", "")
def talk():
    \"\"\"Print more than a pipe holds.\"\"\"
    for _ in range(LINES):
        print("x" * 99)
    return 0

module = types.ModuleType("toy.talk")
module.talk = talk
sys.modules["toy.talk"] = module
sys.exit(CommandGroup("toy", {"talk": ("toy.talk", "print")}, label="toy", description="", epilog="").run(["talk"]))
"""


def test_a_reader_that_leaves_ends_the_program_without_a_word():
    for lines in (1, 10_000):  # at the end of the program, and in the middle of it
        script = TOY.replace("LINES", str(lines))
        with subprocess.Popen(
            [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=BUFFERED
        ) as process:
            process.stdout.close()
            error = process.stderr.read()
            process.wait(timeout=60)

        assert (process.returncode, error) == (1, "")


def test_the_help_of_lockstep_imports_no_numerics():
    code = "import sys\nfrom lockstep.__main__ import main\nmain(['run', '--help'])\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    loaded = {name.partition(".")[0] for name in done.stdout.splitlines()[-1].split()}

    assert loaded & {"numpy", "scipy", "pyarrow", "fmpy", "lxml", "rich", "flexsat", "flexbench"} == set()
