"""Bad scenario files are refused in one line, before any FMU is started."""

import re
from dataclasses import replace

import numpy as np
import pytest

from lockstep import InputError, read_scenario
from lockstep.faults.resolve import resolve
from lockstep.plan.plan import Plan

MS = 1_000_000
BIAS = {"connection": '"echo.u[1]"', "kind": '"bias"', "value": "1.0", "from": "0.01"}


def entry(**changes):
    """Return a file of one fault; a change of None removes a key."""
    keys = BIAS | {key.rstrip("_"): value for key, value in changes.items()}
    return "[[fault]]\n" + "\n".join(f"{key} = {value}" for key, value in keys.items() if value is not None)


def tuned(**changes):
    """Return a file of one fault on a parameter."""
    return entry(connection=None, **changes)


IN_THE_FILE = {
    "[[fault]": "is no TOML file",
    "": r"faults.toml: holds no fault; write \[\[fault\]\] before each",
    "[[faults]]\nkind = 'bias'": "faults.toml: faults: no such table",
    entry(kind='"biass"'): "fault 1: kind = 'biass': no such kind; there are stuck, .* nan; did you mean bias?",
    entry(kind=None): "fault 1: kind is missing; there are stuck, ",
    entry(valu="2.0"): r"fault 1 \(bias\): valu: no such key of bias; there are .*; did you mean value?",
    entry(name='"drift"', factor="2"): r"fault 1 \(drift\): factor: no such key of bias",
    entry(value=None): r"fault 1 \(bias\): value is missing; bias needs it",
    entry(value='"big"'): "value = 'big' must be a number, or a list of numbers",
    entry(value="nan"): 'value = nan must be finite; kind = "nan" makes values that are not',
    entry(value="true"): "value = True must be a number",
    entry(kind='"noise"', value=None, deviation="0.0"): "deviation = 0.0 must be > 0",
    entry(kind='"quantisation"', value=None, step="-1"): "step = -1 must be > 0",
    entry(connection=None): r"write either connection = .* or parameter = ",
    entry(parameter='"gain.gain"'): r"write either connection = .* or parameter = ",
    entry(connection="[]"): r"connection = \[\] is empty",
    entry(connection="3"): "connection = 3 must be a text or a list of texts",
    entry(kind='"delay"', value=None): "ticks is missing; delay needs it",
    entry(kind='"delay"', value=None, ticks="0"): "ticks = 0 must be a whole number >= 1",
    tuned(kind='"delay"', value=None, ticks="1", parameter='"gain.gain"'): "acts on connections",
    tuned(kind='"stuck"', value=None, parameter='"gain.gain"'): "value is missing; stuck needs it",
    entry(kind='"spike"', probability="1.5"): r"probability = 1.5 must be in \(0, 1\]",
    entry(kind='"spike"', seed="3"): "seed = 3: a single spike draws nothing; give probability too, or leave it out",
    entry(kind='"noise"', value=None, deviation="1", seed="-1"): "seed = -1 must be a whole number >= 0",
    entry(from_=None): "write from, and to unless it lasts to the end of the run; or at and duration",
    entry(at="0.02"): "write from, and to",
    entry(duration="0.02"): "duration = 0.02 goes with at",
    entry(from_=None, at="0.02"): "at needs duration as well; or write from, which lasts to the end of the run",
    entry(from_=None, at="0.02", to="0.03"): "to = 0.03 goes with from",
    entry(from_='"soon"'): "from = 'soon' must be a number of seconds, for example 50.0",
    entry(to="0.005"): "to = 0.005 must be > from = 0.01: the window ends at 0.005 s",
    entry(to="0.01"): "to = 0.01 must be > from = 0.01",
    entry(from_=None, at="0.01", duration="0.0"): "duration must be > 0: the window ends at 0.01 s",
    entry(unit="3"): "unit = 3 must be a text",
}  # fmt: skip

AGAINST_THE_SYSTEM = {
    entry(connection='"echo.v[1]"'): r"connection = 'echo.v\[1\]': echo.v\[1\]: no such connected input; there are "
    r"echo.u\[1..2\], echo.flag, echo.number, gain.u",
    entry(connection='"echo.numbr"'): "no such connected input; .*did you mean echo.number?",
    entry(connection='"echo.u[1..3]"'): r"echo.u\[3\]: no such connected input; there are echo.u\[1..2\]",
    entry(connection='"echo.u[2..1]"'): r"the range \[2..1\] is empty",
    entry(connection='"counter.count"'): r"is an output; write 'counter.count -> \*' for all inputs that it feeds",
    entry(connection='"counter.cnt -> echo.*"'): "counter.cnt: no such output that feeds an input; "
    "there are counter.count",
    entry(connection='"counter.steps -> echo.u"'): "echo.u: no such connected input; there are echo.number",
    entry(connection='"angle.radians"'): "nothing feeds this input; write parameter instead",
    entry(connection='"echo.flag"'): "echo.flag is Boolean: bias acts on numbers; use stuck, dropout or delay",
    entry(connection='"echo.number"', kind='"nan"', value=None): "echo.number is Integer; only a Real can be nan",
    entry(connection='"echo.u"', value="[1, 2, 3]"): r"3 numbers for 2 values, echo.u\[1..2\]; give one, or each",
    entry(connection='"echo.u"', kind='"dropout"', value=None): r"no validity flag among echo.u\[1..2\]; add",
    entry(connection='["echo.u", "echo.flag"]', kind='"dropout"', value=None, invalid="3"): "invalid = 3: has no "
    "effect on echo.flag, which becomes false; leave it out",
    entry(connection='"echo.flag"', kind='"stuck"', value="2.0"): "echo.flag: 2.0 is not of its type Boolean",
    entry(unit='"deg"'): r"unit = 'deg': echo.u\[1\] has no unit; leave unit out",
    tuned(parameter='"angle.radians"', unit='"m"'): "unit 'm' .* does not convert",
    tuned(parameter='"angle.radians"', unit='"dgr"'): "'dgr': no such unit; angle.radians is in 'rad'; "
    "there are ",
    tuned(parameter='"counter.gain"'): "counter.gain is not tunable but fixed: the "
    "FMU takes it before the run only; a run can change gain.gain, gain.shift, gain.on, slow",
    tuned(parameter='"gain.u"'): "gain.u is connected: write connection instead",
    tuned(parameter='"gain.y"'): "gain.y is the FMU's output, not a parameter",
    tuned(parameter='"gain.gian"'): "no such parameter; .*; did you mean gain.gain?",
    entry(from_="-1.0"): "begins at -1 s, and the run at 0 s; choose a window inside the run",
    entry(from_="0.1"): "begins at 0.1 s, and the run ends at 0.1 s; choose a window inside the run",
    entry(connection='"slow.u[1]"', from_="0.0101", to="0.0199"): r"no value of counter.count -> "
    r"slow.u\[1\] is transferred in \[0.011, 0.02\) s; the next is at 0.02 s",
}  # fmt: skip


@pytest.fixture(scope="module")
def plan(bench, toys):
    """Return the plan of the bench with a second echo, of 10 ms, and the angles, whose inputs are not connected."""
    echo, count = bench.components[1], bench.connections[0]
    more = (
        replace(echo, name="slow", period=10 * MS, parameters={"u[2]": 0.0, "flag": False, "number": 0}),
        replace(echo, name="angle", source=toys / "toy_angle.fmu",
                parameters={"radians": 0.0, "kelvin": 280.0, "free": 0.0}),
    )  # fmt: skip
    system = replace(
        bench,
        components=(*bench.components, *more),
        connections=(*bench.connections, replace(count, to_component="slow")),
    )
    return Plan(system, None, {}, None, None)


@pytest.mark.parametrize("text", IN_THE_FILE)
def test_bad_file_is_refused(text, scenario):
    path = scenario(text)
    with pytest.raises(InputError, match=IN_THE_FILE[text]) as caught:
        read_scenario(path)
    assert "faults.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", AGAINST_THE_SYSTEM)
def test_fault_that_does_not_fit_the_system_is_refused(text, scenario, plan):
    with pytest.raises(InputError, match=AGAINST_THE_SYSTEM[text]) as caught:
        resolve([read_scenario(scenario(text))], plan)
    assert re.match(r"faults\.toml: fault 1 \(\w+\): ", str(caught.value))
    assert "\n" not in str(caught.value)


def test_units_are_converted(scenario, plan):
    """Values with the unit's offset, differences without; a name of the FMU's own counts too."""

    def altered(**keys):
        text = tuned(**keys)
        (group,) = resolve([read_scenario(scenario(text))], plan).settings
        values = np.array(group.originals, np.float64)
        group.effect.observe(20, values)
        return group.effect.act(20, values)[0]

    assert altered(parameter='"angle.radians"', value="180.0", unit='"deg"') == pytest.approx(3.141592653589793)
    assert altered(parameter='"angle.kelvin"', kind='"stuck"', value="5.0", unit='"K"') == 5.0
    assert altered(parameter='"angle.kelvin"', value="5.0") == 285.0


def test_refused_run_leaves_no_files(bench_ssd, scenario, cli, tmp_path):
    done = cli("run", bench_ssd, "--faults", scenario(entry(connection='"echo.v"')), "--out", tmp_path / "out")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("lockstep: faults.toml: fault 1 (bias): connection = 'echo.v': echo.v: no such")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()
    done = cli("run", bench_ssd, "--faults", tmp_path / "none.toml", "--out", tmp_path / "out")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "none.toml" in done.stderr
