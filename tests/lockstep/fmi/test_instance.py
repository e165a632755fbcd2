"""The life cycle of one instance of FMI 2.0: reported calls, log messages, and what is called after failures."""

import shutil

import fmpy
import numpy as np
import pytest

from fmus.c_fmu import compile_library
from lockstep.errors import RunError
from lockstep.fmi.fmi2 import Fmi2Slave
from lockstep.fmi.instance import Hooks
from lockstep.fmi.library import UnpackedFmu
from lockstep.fmi.slave import DISCARD, ERROR, FATAL, OK, WARNING

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the FMU is compiled with gcc")

# steps are discarded, because the FMU asks for the end from 1 s on, and it does not terminate
CODE = """
#include <stdlib.h>
#include "fmi2Functions.h"
static int ended;
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type kind, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)kind, (void)guid, (void)resources, (void)visible, (void)logging;
    callbacks->logger(callbacks->componentEnvironment, name, fmi2OK, "info", "ready");
    return malloc(1);
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean t, fmi2Real tolerance, fmi2Real start, fmi2Boolean defined,
                               fmi2Real stop)
{
    (void)c, (void)t, (void)tolerance, (void)start, (void)stop;
    return defined ? fmi2OK : fmi2Warning;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean keep)
{
    (void)c, (void)step, (void)keep;
    ended = time >= 1.0;
    return fmi2Discard;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    (void)c;
    *value = kind == fmi2Terminated && ended;
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[])
{
    (void)c, (void)v;
    return n && r[0] == 6 ? (fmi2Status)-1 : fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) { (void)c; return fmi2Error; }
"""


def unpacked(folder, code):
    """Compile an FMU into a folder."""
    (folder / "made.c").write_text(code)
    compile_library(folder / "binaries" / fmpy.platform / "made.so", [folder / "made.c"])
    return UnpackedFmu(name="part", folder=folder, identifier="made", guid="{}")


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    """Return the FMU of CODE in a folder."""
    return unpacked(tmp_path_factory.mktemp("fmu"), CODE)


@pytest.fixture
def calls():
    """Return the list of calls that instances report."""
    return []


@pytest.fixture
def opened(fmu, calls):
    """Return a function that instantiates the FMU; it is closed at the end of the test."""
    slaves = []

    def open_slave(**hooks):
        slaves.append(Fmi2Slave(fmu, Hooks(**{"log": lambda *_: None, "call": calls.append} | hooks)))
        return slaves[-1]

    yield open_slave
    for slave in slaves:
        slave.close()


def started(slave):
    """Initialise an instance."""
    assert [slave.setup_experiment(0.0, 1.0), slave.enter_initialization(), slave.exit_initialization()] == [OK] * 3
    return slave


def test_every_call_is_reported_before_it_is_made(opened, calls):
    slave = started(opened())
    slave.close()
    slave.close()

    assert calls[:3] == ["loading the library", "fmi2Instantiate", ""]
    assert calls[3::2] == [
        "fmi2SetupExperiment", "fmi2EnterInitializationMode", "fmi2ExitInitializationMode", "fmi2Terminate",
        "fmi2FreeInstance", "unloading the library",
    ]  # fmt: skip
    assert set(calls[4::2]) == {""}  # each returns before the next begins
    assert slave.instance.worst == ERROR  # of fmi2Terminate


def test_stop_time_may_be_left_open(opened):
    assert opened().setup_experiment(0.0, None) == WARNING


def test_listener_gets_every_message_and_the_log_those_above_ok(opened):
    heard, logged = [], []
    opened(message=lambda *words: heard.append(words), log=lambda *words: logged.append(words))

    assert heard == [(OK, "info", "part", "ready")]
    assert logged == []


def test_discarded_step_is_described(opened):
    slave = started(opened())

    assert slave.do_step(0.0, 0.1, 1) == DISCARD
    assert slave.outcome("DoStep", DISCARD) == "fmi2DoStep returned fmi2Discard"
    slave.do_step(1.0, 0.1, 1)
    assert slave.outcome("DoStep", DISCARD) == "fmi2DoStep returned fmi2Discard and asked for the end of the simulation"
    assert slave.outcome("DoStep", 17) == "fmi2DoStep returned the unknown status 17"


def test_failed_terminate_is_logged(opened):
    logged = []
    slave = started(opened(log=lambda *words: logged.append(words)))
    slave.close()

    assert logged == [("part", ERROR, "", "fmi2Terminate returned fmi2Error")]


def test_status_below_zero_is_worse_than_all_others(opened):
    slave = started(opened())
    status = slave.getter("Real", np.array([6], np.uint32), np.zeros(1))()

    assert status > FATAL
    assert slave.outcome("GetReal", status) == "fmi2GetReal returned the unknown status -1"


def test_refused_reset_leaves_the_instance_as_it_is(opened):
    slave = started(opened())

    assert slave.reset() == ERROR
    assert slave.instance.stepping


@pytest.mark.parametrize(
    ("status", "called"),
    [(ERROR, ["fmi2FreeInstance", "", "unloading the library", ""]), (FATAL, [])],
)
def test_after_a_failure_only_allowed_calls_are_made(opened, calls, status, called):
    slave = started(opened())
    slave.failed(status)
    calls.clear()
    slave.close()

    assert calls == called


def test_library_without_a_function_of_the_standard_is_refused(tmp_path):
    (tmp_path / "made.c").write_text("")
    library = tmp_path / "binaries" / fmpy.platform / "made.so"
    compile_library(library, [tmp_path / "made.c"])  # the defaults lack fmi2Instantiate and fmi2DoStep

    with pytest.raises(RunError, match=r"^part: cannot load the FMU: .*undefined symbol: fmi2"):
        Fmi2Slave(UnpackedFmu(name="part", folder=tmp_path, identifier="made", guid="{}"), Hooks(log=lambda *_: None))


def test_missing_instance_is_refused_with_what_was_logged(tmp_path):
    logs = 'callbacks->logger(callbacks->componentEnvironment, name, fmi2Error, "error", "no %s", "licence");'
    code = CODE.replace("    return malloc(1);", f"    {logs}\n    return NULL;")
    hooks = Hooks(log=lambda *_: None)

    with pytest.raises(RunError, match=r"^part: cannot be instantiated: no licence$"):
        Fmi2Slave(unpacked(tmp_path, code), hooks)
