"""Run a script as on a system without the modules and functions that Linux alone has."""

import json
import subprocess
import sys

MISSING = ["fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog"]
DELETED = ["fork", "memfd_create", "sched_setaffinity", "sched_getaffinity", "getsid", "sysconf"]

_PREPARE = """
import importlib.abc, json, os, signal, sys
import psutil  # has its own code for each system; that for Linux imports `resource`

class Blocker(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name in MISSING:
            raise ImportError(f"{name} is missing on this system")
        return None

MISSING = set(json.loads(sys.argv[1]))
for name in MISSING:
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Blocker())
for module, names in ((os, json.loads(sys.argv[2])), (signal, ["pthread_sigmask"])):
    for name in names:
        delattr(module, name)
"""


def run_without(source, *arguments):
    """Run a script, its arguments in `sys.argv[3:]`, in a process without those modules and functions."""
    command = [sys.executable, "-W", "error", "-c", _PREPARE + source, json.dumps(MISSING), json.dumps(DELETED)]
    return subprocess.run([*command, *map(str, arguments)], capture_output=True, text=True, check=False, timeout=120)
