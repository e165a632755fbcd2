"""Values of a run between two ticks: every type is read, free inputs and tunable parameters are set, others refused."""

import re

import numpy as np
import pytest

import lockstep
from lockstep import Component, InputError
from lockstep.adapter.component import replace_component
from lockstep.adapter.read import read_adapter
from lockstep.faults.read import read_scenario


@pytest.fixture
def echo(echo_alone):
    with lockstep.open(echo_alone, record=["echo.out.h"]) as run:
        yield run


@pytest.mark.parametrize(
    ("name", "value", "read"),
    [
        ("x", 1.5, 1.5),
        ("x", np.float64(2.5), 2.5),
        ("x", 3, 3.0),
        ("x", "0.5 rad", 0.5 / (np.pi / 180.0)),
        ("x", "-1deg", -1.0),
        ("n", 7, 7),
        ("n", "8", 8),
        ("b", True, True),
        ("b", "false", False),
        ("s", "ein Wört", "ein Wört"),
    ],
)
def test_each_type_is_set_and_read_as_itself(echo, name, value, read):
    """`out.` gives at the end of a step what was set; nothing of it is recorded."""
    echo.set(f"echo.{name}", value)
    echo.step()
    found = echo[f"echo.out.{name}"]

    assert found == (pytest.approx(read, rel=1e-15) if isinstance(read, float) else read)
    assert type(found) is type(read)
    assert echo[f"echo.{name}"] == found  # the input itself
    assert (echo["echo.gain"], echo["echo.inner"]) == (3.0, 3.0 * echo["echo.x"])  # parameter and local


def test_an_input_keeps_its_value_and_can_be_set_as_an_item(echo):
    echo["echo.h"] = 4.0
    echo.step(3)
    echo["echo.h"] = 5.0
    echo.step()
    assert echo["echo.out.h"] == 5.0
    assert echo.signals["echo.out.h"].tolist() == [0.0, 4.0, 4.0, 4.0]


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("echo.n", 10, r"echo\.n: 10 is outside \[-inf, 9\.0\], which the FMU declares"),
        ("echo.x", float("nan"), r"echo\.x: nan must be finite"),
        ("echo.x", np.inf, r"echo\.x: inf must be finite"),
        ("echo.x", "3 kg", r"echo\.x = '3 kg': unit"),
        ("echo.x", [1.0, 2.0], r"echo\.x: got 2 values for one parameter"),
        ("echo.x", None, r"echo\.x: None cannot be kept; give a number"),
        ("echo.b", 1.0, r"echo\.b: 1\.0 is not of its type Boolean; write true or false"),
        ("echo.gain", 2.0, r"echo\.gain: is a fixed parameter, which cannot change while the FMU runs; give it when "
                           r"the run is opened: overrides=\{'echo\.gain': VALUE\}"),
        ("echo.out.x", 2.0, r"echo\.out\.x: is the FMU's output; only parameters and inputs can be set"),
        ("echo.inner", 2.0, r"echo\.inner: is the FMU's local"),
        ("echo.y", 2.0, r"echo\.y: no such"),
        ("x", 2.0, r"x: write component\.variable; components are echo"),
    ],
)  # fmt: skip
def test_what_cannot_be_set_is_refused_and_the_run_goes_on(echo, name, value, message):
    echo.set("echo.x", 0.25)
    with pytest.raises(InputError, match=message):
        echo.set(name, value)
    echo.step()
    assert (echo["echo.out.x"], echo["echo.out.n"]) == (0.25, 0)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("echo.out.z", r"echo\.out\.z: no such variable; echo has .*did you mean out\.x\?"),
        ("eco.x", r"eco\.x: write component\.variable; components are echo; did you mean echo\.x\?"),
        ("out.x", r"out\.x: write component\.variable; components are echo"),
        ("echo", r"echo: write component\.variable"),
    ],
)
def test_unknown_names_are_refused_with_the_nearest(echo, name, message):
    with pytest.raises(InputError, match=message):
        echo[name]


def test_connected_inputs_are_refused_until_their_source_is_left_out(triple):
    with lockstep.open(triple) as run:
        for value in (1.0, "1", np.float64(1.0)):
            refused = ("b.u: is connected to a.y, so that a value for it has no effect; open the run without that "
                       "connection, as System.without(component) does, or inject a fault of kind stuck")  # fmt: skip
            with pytest.raises(InputError, match=re.escape(refused)):
                run.set("b.u", value)
        run.set("b.gain", 2.0)  # tunable
        run.step(4)
        assert run["b.gain"] == 2.0
    with lockstep.open(triple.without("a")) as run:
        run.set("b.u", 1.0)
        run.step(4)
        assert run["b.u"] == 1.0
        assert list(run.signals) == [name for name in run.signals if not name.startswith("a.")] != []
    with pytest.raises(InputError, match="c: no such component; there are a, b, p"):
        triple.without("c")


def test_what_faults_set_and_files_feed_is_refused(triple, tmp_path):
    (tmp_path / "faults.toml").write_text(
        '[[fault]]\nname = "x"\nparameter = "p.gain"\nkind = "scale"\nfactor = 2.0\nfrom = 0.02\nto = 0.03\n'
    )
    (tmp_path / "in.csv").write_text("time,p.offset\n0,1\n0.01,2\n")
    options = {"faults": [read_scenario(tmp_path / "faults.toml")], "inputs": tmp_path / "in.csv"}
    with lockstep.open(triple, **options) as run:
        with pytest.raises(InputError, match=r"p\.gain: a fault sets it; leave out the fault"):
            run.set("p.gain", 1.0)
        for value in (1.0, "1"):
            with pytest.raises(InputError, match=r"p\.offset: an input file feeds it, .*; leave out its column"):
                run.set("p.offset", value)
        run.step(11)
        assert run["p.offset"] == 2.0


def test_arrays_are_read_and_set_whole(toys):
    part = Component(name="toy_echo", source=toys / "toy_echo.fmu", period=1_000_000, kind="sampled", isolated=False)
    with lockstep.open({"toy_echo": part}) as run:
        run.set("toy_echo.u", np.array([1.0, 2.0]))
        run.step()
        assert run["toy_echo.y"].tolist() == [1.0, 2.0]
        run.set("toy_echo.u", [3, 4.5])
        run.step()
        assert run["toy_echo.y"].tolist() == [3.0, 4.5]
        run.set("toy_echo.u", 7.0)  # one value for all
        run.set("toy_echo.u[2]", 8.0)
        run.step()
        first, second = run["toy_echo.y"], run["toy_echo.y[2]"]
        assert (first.tolist(), second) == ([7.0, 8.0], 8.0)
        run.set("toy_echo.u", "[0.5, 1.5]")
        run.step()
        assert first.tolist() == [7.0, 8.0]  # a copy
        with pytest.raises(InputError, match=r"toy_echo\.u: got 3 values for u\[1\.\.2\]"):
            run.set("toy_echo.u", np.zeros(3))
        assert {"toy_echo.u", "toy_echo.u[1]", "toy_echo.y"} <= set(run._ipython_key_completions_())


def test_values_behind_an_adapter_are_those_of_its_ports(triple, fmus, tmp_path):
    ports = (("input", "u"), ("input", "number"), ("input", "flag"), ("input", "offset"), ("output", "y"),
             ("output", "began"), ("output", "steps"), ("output", "odd"))  # fmt: skip
    path = tmp_path / "same.toml"
    path.write_text("".join(f'[[{kind}]]\nport = "{name}"\nvariable = "{name}"\n' for kind, name in ports))
    adapted = replace_component(triple, "a", fmus["good"], read_adapter(path))
    with lockstep.open(triple) as plain, lockstep.open(adapted) as run:
        for one in (plain, run):
            one.step(3)
            one.set("a.gain", 3.0)
            one.set("a.offset", 0.5)
            one.step(10)
        names = ("a.y", "a.steps", "a.odd", "a.gain", "a.seed", "a.offset", "b.y")
        assert [run[name] for name in names] == [plain[name] for name in names]
