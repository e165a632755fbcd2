"""OspSystemStructure.xml is read as libcosim reads it."""

import shutil

import pytest

from lockstep import InputError, load_system, read_signals, simulate
from lockstep.ssp.write import write_ssd

MS = 1_000_000  # [ns]
NAMESPACE = "http://opensimulationplatform.com/MSMI/OSPModelDescription"
GROUPS = f"""<OspModelDescription xmlns="{NAMESPACE}" version="0.1">
<VariableGroups>{{}}</VariableGroups></OspModelDescription>"""


@pytest.fixture
def osp(tmp_path, fmus):
    """Return a function that writes a system; the FMUs lie beside it."""
    for name in ("counter", "echo", "integrator"):
        shutil.copy(fmus[name], tmp_path / f"{name}.fmu")

    def write(simulators, connections="", functions="", head="<BaseStepSize>1e-3</BaseStepSize>"):
        path = tmp_path / "OspSystemStructure.xml"
        path.write_text(
            '<OspSystemStructure xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure" version="0.1">'
            f"{head}<Simulators>{simulators}</Simulators>{functions}<Connections>{connections}</Connections>"
            "</OspSystemStructure>"
        )
        return path

    return write


def simulator(name, source, step="", values=""):
    step = f' stepSize="{step}"' if step else ""
    return f'<Simulator name="{name}" source="{source}.fmu"{step}><InitialValues>{values}</InitialValues></Simulator>'


def initial(variable, kind, value):
    return f'<InitialValue variable="{variable}"><{kind} value="{value}"/></InitialValue>'


def wire(*ends, tag="Variable"):
    inner = "".join(f'<{tag} simulator="{end.split(".")[0]}" name="{end.split(".")[1]}"/>' for end in ends)
    return f"<{tag}Connection>{inner}</{tag}Connection>"


def signal(variable, function, name, group=""):
    owner, port = variable.split(".")
    ends = f'<Variable{group} simulator="{owner}" name="{port}"/><Signal{group} function="{function}" name="{name}"/>'
    return f"<Signal{group}Connection>{ends}</Signal{group}Connection>"


def test_time_begins_at_the_start_time_and_steps_may_be_no_whole_nanoseconds(osp, tmp_path):
    head = "<StartTime>2.5</StartTime><EndTime>2.6</EndTime><BaseStepSize>0.016666666666666666</BaseStepSize>"
    system = load_system(osp(simulator("one", "counter"), head=head)).with_isolation("one", False)
    assert simulate(system, tmp_path / "out").rows == 7
    assert read_signals(tmp_path / "out").time.tolist() == [(150 + k) / 60 for k in range(7)]


def test_steps_values_and_connections(osp, tmp_path):
    path = osp(
        simulator("one", "counter", "2.9e-3", initial("gain", "Real", 2.0))
        + simulator("two", "integrator", values=initial("x0", "Real", 5)),
        wire("two.u", "one.count"),  # in any order: the FMUs decide
        head="<EndTime>0.01</EndTime><BaseStepSize>1e-3</BaseStepSize>",
    )
    system = load_system(tmp_path)  # the folder of the file
    assert system.path == path
    assert {part.name: part.period for part in system.components} == {"one": 2 * MS, "two": MS}
    assert [str(c) for c in system.connections] == ["one.count -> two.u"]
    assert [c.delay for c in system.connections] == [1]  # all read before they step, as libcosim does
    assert (system.tick, system.stop_time) == (MS, 10 * MS)
    assert system.warnings == (
        f"{path}: one: stepSize 2.9e-3 is no multiple of the base step; it is stepped every 0.002 s",
    )
    for name in ("one", "two"):
        system = system.with_isolation(name, False)
    simulate(system, tmp_path / "out")
    seen = read_signals(tmp_path / "out")
    # x is true at the end of a step, and u is what the counter has after 1, 2, ... steps of 2 ms, each worth 2
    inputs = [0.0, 0.0, 2.0, 2.0, 4.0, 4.0, 6.0, 6.0, 8.0, 8.0]
    assert seen["two.x"].tolist() == pytest.approx([5.0 + 1e-3 * sum(inputs[:k]) for k in range(11)])


def test_a_linear_transformation_is_part_of_the_connection(osp):
    functions = '<Functions><LinearTransformation name="scale" factor="0.1" offset="123.4"/></Functions>'
    connections = signal("one.count", "scale", "in") + signal("two.u", "scale", "out")
    (found,) = load_system(
        osp(simulator("one", "counter") + simulator("two", "integrator"), connections, functions)
    ).connections
    assert (str(found), found.factor, found.offset) == ("one.count -> two.u", 0.1, 123.4)


SUM = '<Functions><Sum name="sum" inputCount="3"/></Functions>'


def test_a_calculated_parameter_is_a_source(osp, tmp_path, reference):
    more = (
        '<ScalarVariable name="c" valueReference="{}" causality="calculatedParameter" variability="fixed" '
        'initial="calculated"><Real/></ScalarVariable>'
    )
    number = next(k for k, v in enumerate(reference.variables_of("integrator", "2.0")) if v.name == "x0")
    built = reference.build("integrator", "2.0", tmp_path / "built", more=more.format(number))
    path = osp(simulator("one", "calculating") + simulator("two", "echo"), wire("one.c", "two.u[1]"))
    shutil.copy(built, tmp_path / "calculating.fmu")
    system = load_system(path).with_isolation("one", False).with_isolation("two", False)
    simulate(system, tmp_path / "out", stop_time=0.004, overrides={"one.x0": 3.0})
    assert read_signals(tmp_path / "out")["two.y[1]"].tolist()[1:4] == [3.0, 3.0, 3.0]
    write_ssd(system, tmp_path / "as.ssd")
    assert [str(c) for c in load_system(tmp_path / "as.ssd").connections] == ["one.c -> two.u[1]"]


def test_a_sum_adds_its_inputs_without_a_delay(osp, tmp_path):
    parts = simulator("one", "counter", values=initial("gain", "Real", 0.1)) + simulator(
        "two", "counter", "2e-3", initial("gain", "Real", 3.0)
    )
    connections = "".join(signal(f"{n}.count", "sum", f"in[{i}]") for i, n in enumerate(("one", "two", "one")))
    parts += simulator("sink", "echo")
    system = load_system(
        osp(parts, connections + signal("sink.u[1]", "sum", "out") + wire("one.count", "sink.u[2]"), SUM)
    )
    for name in ("one", "two", "sink"):
        system = system.with_isolation(name, False)
    simulate(system, tmp_path / "out", stop_time=0.008)
    seen = read_signals(tmp_path / "out")
    rows = range(len(seen.time))
    # the counters are continuous: after k steps they have k; the sum is that of the values which u[2] has as well
    ones, twos = [0.1 * k for k in rows], [3.0 * (k // 2) for k in rows]
    assert seen["sum.out"].tolist() == [one + two + one for one, two in zip(ones, twos, strict=True)]
    assert seen["sink.y[2]"].tolist()[1:] == ones[:-1]
    assert seen["sink.y[1]"].tolist()[1:] == seen["sum.out"].tolist()[:-1]
    with pytest.raises(InputError, match=r"^sum: sums of an OspSystemStructure\.xml, which SSP cannot express"):
        write_ssd(system, tmp_path / "out.ssd")


def test_a_sum_of_vectors_is_connected_by_groups(osp, tmp_path):
    for model, group, ports in (("ToyCounter", "c", ("count", "began")), ("ToyEcho", "e", ("u[1]", "u[2]"))):
        variables = "".join(f'<Variable ref="{port}"/>' for port in ports)
        (tmp_path / f"{model}_OspModelDescription.xml").write_text(
            GROUPS.format(f'<Generic name="{group}">{variables}</Generic>')
        )
    parts = simulator("one", "counter") + simulator("two", "counter") + simulator("sink", "echo")
    functions = '<Functions><VectorSum name="sum" inputCount="2" dimension="2"/></Functions>'
    ends = (("one.c", "in[0]"), ("two.c", "in[1]"), ("sink.e", "out"))
    connections = "".join(signal(end, "sum", name, "Group") for end, name in ends)
    found = [str(c) for c in load_system(osp(parts, connections, functions)).connections]
    assert found == [
        *("one.count -> sum.in[0][0]", "one.began -> sum.in[0][1]", "two.count -> sum.in[1][0]"),
        *("two.began -> sum.in[1][1]", "sum.out[0] -> sink.u[1]", "sum.out[1] -> sink.u[2]"),
    ]


def test_groups_are_connected_in_the_order_of_their_variables(osp, tmp_path):
    for model, ports in (("ToyCounter", ("count", "began")), ("ToyEcho", ("u[1]", "u[2]"))):
        force, speed = (f'<{t} name="{t}"><Variable ref="{p}"/></{t}>' for t, p in zip(("F", "V"), ports, strict=True))
        (tmp_path / f"{model}_OspModelDescription.xml").write_text(
            GROUPS.format(f'<LinearMechanicalPort name="port">{force}{speed}</LinearMechanicalPort>')
        )
    parts = simulator("one", "counter") + simulator("two", "echo")
    connections = load_system(osp(parts, wire("one.port", "two.port", tag="VariableGroup"))).connections
    assert [str(c) for c in connections] == ["one.count -> two.u[1]", "one.began -> two.u[2]"]
    newer = tmp_path / "ToyEcho_OspModelDescription.xml"
    text = newer.read_text().replace(NAMESPACE, "https://open-simulation-platform.com/OspModelDescription/1.0.1")
    newer.write_text(text)
    (alone,) = load_system(osp(parts, wire("one.F", "two.F", tag="VariableGroup"))).connections
    assert str(alone) == "one.count -> two.u[1]"
    (tmp_path / "ToyEcho_OspModelDescription.xml").unlink()
    with pytest.raises(InputError, match=r"^two: no ToyEcho_OspModelDescription\.xml beside its FMU or the system"):
        load_system(osp(parts, wire("one.port", "two.port", tag="VariableGroup")))


BAD = [
    (simulator("a", "counter") + simulator("a", "echo"), "", "", r"simulator a: declared twice"),
    (simulator("a", "counter"), wire("a.count", "b.u"), "", r"^b: no such simulator; there are a"),
    (simulator("a", "counter"), wire("a.count", "a.v"), "", r"^a\.v: no such output; a has"),
    (simulator("a", "counter", values=initial("gian", "Real", 1)), "", "", r"^a\.gian: no such parameter; .*gain"),
    (simulator("a", "counter", values=initial("gain", "Real", "x")), "", "", r"^a\.gain: 'x' is no value of type Real"),
    (simulator("a", "counter"), signal("a.count", "sum", "in[3]"), SUM,
     r"^function sum: no signal in\[3\]; it has out, in\[0\.\.2\]"),
    (simulator("a", "counter"), signal("a.count", "sun", "in[0]"), SUM, r"function sun: no such function; .*sum"),
    (simulator("a", "counter"), signal("a.count", "sum", "in", "Group"), SUM, r"^function sum: no signal group in; it"),
    (simulator("a", "counter"), "", SUM.replace("3", "x"), r"function sum: inputCount 'x' must be a whole number"),
    (simulator("a", "counter"), "", SUM.replace("Sum", "Product"), r"function sum: Product is not supported; use Lin"),
    (simulator("sum", "counter"), signal("sum.count", "sum", "in[0]"), SUM, r"function sum: a simulator has this name"),
    (simulator("a", "no"), "", "", r"^a: no such file .*no\.fmu"),
]  # fmt: skip


@pytest.mark.parametrize(("simulators", "connections", "functions", "message"), BAD)
def test_bad_systems_are_refused_in_one_line(osp, simulators, connections, functions, message):
    with pytest.raises(InputError, match=message) as caught:
        load_system(osp(simulators, connections, functions))
    assert "\n" not in str(caught.value)
