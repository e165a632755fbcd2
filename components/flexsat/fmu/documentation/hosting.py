"""How to run one of our FMUs: in a host with Python, and in one without. The sections that all components share."""

from __future__ import annotations

from html import escape

from .tables import code

OLDEST_PYTHON = (3, 11)  # the sources need it; CPython's stable ABI lets the binary load any newer one
DEPENDENCIES = f"""\
What this FMU needs beside itself
=================================

1. CPython {OLDEST_PYTHON[0]}.{OLDEST_PYTHON[1]} or newer, 64 bit; the binary uses CPython's stable ABI
   and is not bound to one version.
   - Linux x86-64: the library of Python must be in the process, with its symbols global, before fmi2Instantiate. In a
     host written in Python it is. In any other host the FMU loads libpython3.11.so.1.0 by itself, the version it was
     built with, where the system finds it (Debian: package libpython3.11; elsewhere LD_LIBRARY_PATH). Another version
     has to be preloaded:
         LD_PRELOAD=/usr/lib/x86_64-linux-gnu/libpython3.13.so.1 host ...
     or loaded by the host, before the FMU is instantiated:
         dlopen("libpython3.13.so.1.0", RTLD_NOW | RTLD_GLOBAL)
     What is missing is told in the host's log, and fmi2Instantiate returns NULL.
     The C++ run-time library of the system (libstdc++.so.6) and glibc 2.32 or newer are needed too.
   - Windows x86-64: the binary imports python3.dll, which must be on PATH, and the Visual C++ run-time library.
     The Windows binary travels along; it has not been tried by the makers of this FMU.
2. numpy, where that Python finds it: installed for it, or its folder in PYTHONPATH. If the library of Python does not
   find the Python it belongs to by itself, set PYTHONHOME to its prefix.
On Linux the folder it is unpacked to may have any path but one with the letters %20 in it, and fmuResourceLocation
may be any URI of it: file:///path, file:/path, percent-encoded or not. The Windows binary is pythonfmu's wrapper alone,
which decodes %20 and nothing else: unpack to a folder of ASCII letters there.

binaries/linux64 holds two libraries: the one that a host loads, named after the model, and libpythonfmu-export.so, the
wrapper of pythonfmu 0.7, which the first one loads from the same folder.

Nothing else: no network, no licence server, no other files. The Python package pythonfmu, which calls the model, and
all sources of the model travel in resources/; nothing needs to be installed for them. The FMU finds them through
fmuResourceLocation, never through the working directory.

Set OPENBLAS_NUM_THREADS=1 before the host starts: the matrices are small, and threads cost more than they bring.
"""

_PYTHON = """\
from fmpy import simulate_fmu

result = simulate_fmu("{file}", stop_time={stop}, step_size={step}, output_interval={step}, output=["{output}"])
print(result["time"][-1], result["{output}"][-1])
"""
_PRELOAD = """\
export OPENBLAS_NUM_THREADS=1
export PYTHONPATH=/folder/with/numpy                        # only if that Python does not find numpy by itself
host plant.fmu                                              # with libpython3.11.so.1.0 where the system finds it, or
LD_PRELOAD=/usr/lib/x86_64-linux-gnu/libpython3.13.so.1 host plant.fmu
"""


def hosting_section(file: str, step: float, stop: float, output: str) -> str:
    """Return the HTML of how to run it; `output` is a variable that the example reads."""
    example = escape(_PYTHON.format(file=file, stop=stop, step=step, output=output))
    return f"""\
<h3>In Python</h3>
<p>With Python {OLDEST_PYTHON[0]}.{OLDEST_PYTHON[1]} or newer and numpy; here with FMPy. No other package is needed:
{code("pythonfmu")} travels in {code("resources/")}.</p>
<pre>{example}</pre>
<h3>In a host without Python</h3>
<p>The model is Python, and the library of Python must be in the process. The FMU loads
{code("libpython3.11.so.1.0")}, the version it was built with, by itself; another version has to be preloaded, with
its symbols global:</p>
<pre>{escape(_PRELOAD)}</pre>
<p>or loaded by the host's own code, {code('dlopen("libpython3.13.so.1.0", RTLD_NOW | RTLD_GLOBAL)')}.
Any version from 3.11 on does, if numpy is there for it: the binary uses CPython's stable ABI. What is missing is told
in the host's log, and {code("fmi2Instantiate")} returns NULL.
<a href="externalDependencies.txt">externalDependencies.txt</a> says it all, with Windows.</p>
<p>The model description says {code('needsExecutionTool="true"')} for that reason.</p>
"""


ERRORS_SECTION = f"""\
<p>A call that fails is logged at once, with status {code("fmi2Error")} and category {code("logStatusError")}, the only
one there is, if logging is on; the message names the variable, the value and what is accepted. From then on every
{code("fmi2DoStep")} returns {code("fmi2Discard")}, {code("fmi2GetBooleanStatus(fmi2Terminated)")} is true, and all
real outputs read not-a-number, so that nobody takes them for results. {code("fmi2Reset")}, or setting a saved state,
makes the instance usable again. The calls that set and get values return {code("fmi2OK")} even then: the wrapper
cannot return {code("fmi2Error")}, and after {code("fmi2Fatal")} it would free the instance twice.</p>
<p>Errors are: a step that is not accepted; a value out of its range or not finite; a parameter that is set after
initialisation; parameters that contradict each other, refused when initialisation ends; an output that is not
finite.</p>
"""
