"""System files of other tools that are slightly off run with a warning; inputs without a source keep their starts."""

import tomllib
import zipfile

import pytest

from lockstep import InputError, load_system, read_signals, simulate
from lockstep.fmi.model_description import read_description
from lockstep.fmi.parameter_values import component_parameters
from lockstep.ssp.step_times import Timing

EACH_MS = Timing(period=1_000_000)  # ns


@pytest.fixture
def echo(ssd, fmus):
    """Return a system of an echo, with one connector, and more inside of the component and the system."""

    def build(connector="u[1] input", inner="", connections="", connectors=()):
        return ssd.system("top", ssd.component("echo", fmus["echo"], connector, inner=inner), connections, connectors)

    return build


def test_an_unconnected_input_keeps_its_start_value_and_is_listed_once(load, run, ssd, fmus, tmp_path):
    integrator = ssd.component("plant", fmus["integrator"], "x output")
    system = load(ssd.system("top", ssd.component("echo", fmus["echo"], "u[1] input") + integrator,
                             ssd.connection("plant.x", "echo.u[1]")))  # fmt: skip
    seen = run(system)
    assert seen["echo.y[2]"].tolist() == [0.0] * 11
    assert simulated(system, tmp_path).warnings[-1] == (
        "not connected, and keep their start values: echo.u[2], flag, number; plant.u"
    )


def simulated(system, folder):
    """Return the summary of a run in which the first component has the process of the master."""
    return simulate(system.with_isolation(system.components[0].name, False), folder / "summary")


def warnings_of(system):
    """Return the warnings, but for that of the toys' folder."""
    return [text for text in system.warnings if "sources outside" not in text]


def test_empty_attributes_are_read_as_not_given(load, echo, run):
    text = echo("u[1] input Real unit=", connections='<ssd:Connection startElement="" startConnector="in" '
                'endElement="echo" endConnector="u[1]"/>', connectors=("in input",))  # fmt: skip
    system = load(text)
    assert [text.partition(": ")[2] for text in warnings_of(system)] == [
        'unit="" is read as no unit',
        'startElement="" is read as the system itself',
    ]
    assert all(", line 1: " in text for text in warnings_of(system))
    assert run(system, overrides={"in": 3.0})["echo.y[1]"][-1] == 3.0


def test_what_the_file_does_not_define_is_left_to_the_fmu(load, ssd, fmus, run):
    modes = ssd.component("modes", fmus["modes"], "number input Enumeration name=Aircraft", "u[1] input Real unit=Nm")
    system = load(ssd.system("top", modes))
    assert warnings_of(system) == [
        "modes.number: enumeration 'Aircraft' is not defined; the items are the FMU's, the file has none",
        "modes.u[1]: unit 'Nm' is left out, as the file defines only rad, deg, K, degC",
    ]
    assert run(system, overrides={"modes.number": "fine"})["modes.number_out"][-1] == 4


@pytest.mark.parametrize(("unit", "seen"), [("[deg]", 3.141592653589793), ("deg", 3.141592653589793)])
def test_the_unit_of_a_value_may_be_in_brackets(load, ssd, fmus, unit, seen):
    values = ssd.bindings(ssd.binding(ssd.values(("radians", "Real", 180.0, unit))))
    system = load(ssd.system("top", ssd.component("angle", fmus["angle"], inner=values)))
    assert [text for text in system.warnings if "deg" in text] == (
        ["angle.radians: unit '[deg]' is read as deg"] if unit == "[deg]" else []
    )
    (part,) = system.components
    assert component_parameters(part, read_description(part))["radians"] == pytest.approx(seen, rel=1e-15)


def test_a_value_in_an_unknown_unit_is_refused_where_a_variable_takes_it(load, ssd, fmus, run):
    values = ssd.bindings(ssd.binding(ssd.values(("radians", "Real", 1.0, "furlong"))))
    system = load(ssd.system("top", ssd.component("angle", fmus["angle"], inner=values)))
    assert warnings_of(system) == ["angle.radians: unit 'furlong' is not defined; the file defines rad, deg, K, degC"]
    with pytest.raises(InputError, match=r"angle\.radians: units 'furlong' and 'rad' cannot be compared"):
        run(system)


def test_the_last_of_two_values_of_one_name_is_used(load, ssd, fmus):
    values = ssd.bindings(ssd.binding(ssd.values(("u[1]", "Real", 1.0), ("u[1]", "Real", 2.0))))
    system = load(ssd.system("top", ssd.component("echo", fmus["echo"], inner=values)))
    assert system.components[0].parameters["u[1]"] == 2.0
    assert warnings_of(system) == ["echo: inline: parameter u[1]: declared twice; the last value is used"]


def test_unknown_attributes_and_another_order_are_mended(load, echo):
    text = echo().replace('name="u[1]"', 'name="u[1]" type="Real"')
    connectors = '<ssd:Connectors><ssd:Connector name="in" kind="input"/></ssd:Connectors>'
    system = load(text.replace("</ssd:Elements>", f"</ssd:Elements>{connectors}"))
    assert {text.partition("line 1: ")[2] for text in warnings_of(system)} == {
        "attribute type of Connector is left out, as SSP has none",
        "the children of System are not in the order of SSP",
    }


def test_two_groups_of_bindings_are_both_read_and_an_empty_group_is_left_out(load, ssd, fmus):
    first, second = (
        ssd.bindings(ssd.binding(ssd.values(one))) for one in (("u[1]", "Real", 1.0), ("u[2]", "Real", 2.0))
    )
    system = load(ssd.system("top", ssd.component("echo", fmus["echo"], inner=ssd.bindings() + first + second)))
    assert system.components[0].parameters == {"u[1]": 1.0, "u[2]": 2.0}
    assert [text.rpartition(": ")[2] for text in warnings_of(system)] == [
        "ParameterBindings of Component is empty, and left out",
        "ParameterBindings of Component are there twice; both are read",
    ]


def test_a_prefix_without_a_declaration_is_that_of_ssp_or_osp(tmp_path, ssd, fmus):
    hint = '<ssd:Annotations><ssc:Annotation type="com.opensimulationplatform"><osp:StepSizeHint value="5e-3"/>'
    hint += "</ssc:Annotation></ssd:Annotations>"
    path = tmp_path / "foreign.ssd"
    path.write_text(ssd.document(ssd.system("top", ssd.component("echo", fmus["echo"], inner=hint))))
    system = load_system(path)
    assert system.components[0].period == 5_000_000
    namespace = "http://opensimulationplatform.com/SSP/OSPAnnotations"
    assert warnings_of(system) == [f"{path}: prefix osp is not declared; {namespace} is used"]
    path.write_text(path.read_text().replace("osp:", "other:"))
    with pytest.raises(InputError, match=r"not readable XML: Namespace prefix other on StepSizeHint is not defined"):
        load_system(path)


def test_a_run_prints_and_records_its_warnings(tmp_path, cli, ssd, fmus):
    path = tmp_path / "foreign.ssd"
    text = ssd.document(ssd.system("top", ssd.component("echo", fmus["echo"], "u[1] input Real unit=")))
    path.write_text(text.replace(' stopTime="0.01"', ""))
    words = ("run", path, "--out", tmp_path / "out", "--share-process", "echo", "--set", "echo.number=1")
    done = cli(*words)
    assert done.returncode == 0, done.stderr
    expected = [
        f'{path}, line 1: unit="" is read as no unit',
        "echo: neither the file nor the FMU gives a step size: stepped every 0.001 s; --step-size changes it",
        f"echo: sources outside {tmp_path}, the folder of the system file; --within DIR refuses them",
        "no stop time is given: 1 s are simulated; --stop-time changes it",
        "not connected, and keep their start values: echo.u[1..2], flag",
    ]
    assert [line for line in done.stderr.splitlines() if "warning" in line] == [f"warning: {line}" for line in expected]
    assert tomllib.loads((tmp_path / "out" / "run.toml").read_text())["warnings"] == expected
    refused = cli(*words, "--strict-inputs", "--overwrite")
    assert refused.returncode == 2
    assert refused.stderr.splitlines()[-1].startswith("lockstep: echo.u[1..2], flag: not connected and without a value")


def test_one_fmu_alone_is_a_system(tmp_path, fmus):
    system = load_system(fmus["integrator"], Timing(period=1_000_000))
    (part,) = system.components
    assert (part.name, part.kind, system.tick) == ("toy_integrator", "continuous", 1_000_000)
    shared = system.with_isolation("toy_integrator", False)
    summary = simulate(shared, tmp_path / "out", stop_time=0.01, overrides={"toy_integrator.u": 2.0})
    assert summary.rows == 11  # with the one at the stop time
    assert summary.warnings == ()


def altered(source, target, *changes):
    """Copy an FMU with texts of its model description replaced."""
    with zipfile.ZipFile(source) as given, zipfile.ZipFile(target, "w") as written:
        for member in given.infolist():
            content = given.read(member)
            if member.filename == "modelDescription.xml":
                text = content.decode()
                for old, new in changes:
                    assert old in text
                    text = text.replace(old, new, 1)
                content = text.encode()
            written.writestr(member, content)
    return target


def test_the_experiment_of_one_fmu_alone_is_simulated(tmp_path, fmus):
    """From its start time on, to the last whole step before its stop time."""
    given = '<DefaultExperiment startTime="1.5" stopTime="1.5335" stepSize="0.016666666666666666"/>'
    fmu = altered(fmus["integrator"], tmp_path / "x.fmu", ("<ModelVariables>", f"{given}<ModelVariables>"))
    system = load_system(fmu).with_isolation("x", False)
    simulate(system, tmp_path / "out", overrides={"x.u": 2.0, "x.x0": 0.0})
    signals = read_signals(tmp_path / "out")
    assert signals.time.tolist() == [1.5, 91 / 60, 92 / 60]
    assert signals["x.x"].tolist() == pytest.approx([0.0, 1 / 30, 2 / 30], abs=1e-16)


def test_a_model_description_with_small_offences_is_read_with_a_warning(tmp_path, fmus):
    fmu = altered(fmus["echo"], tmp_path / "echo.fmu", ("<Real", '<Real unit="parsec"'))
    system = load_system(fmu, EACH_MS).with_isolation("echo", False)
    summary = simulate(system, tmp_path / "out", stop_time=0.01, overrides={"echo.u[1]": 2.0})
    assert read_signals(tmp_path / "out")["echo.y[1]"][-1] == 2.0
    (text,) = (line for line in summary.warnings if line.startswith("echo: echo.fmu: "))
    assert text.startswith('echo: echo.fmu: modelDescription.xml: The unit "parsec" of variable "u[1]"')
    with pytest.raises(InputError, match=r"^echo: echo\.fmu: .*parsec.*; with --strict this is an error$"):
        simulate(system, tmp_path / "strict", stop_time=0.01, strict=True)
    assert not (tmp_path / "strict").exists()


def test_names_of_locals_may_be_there_twice_but_those_of_ports_may_not(tmp_path, fmus):
    locals_ = '<ScalarVariable name="twin" valueReference="{}" causality="local"><Real/></ScalarVariable>'
    two = "".join(map(locals_.format, (901, 902)))
    fmu = altered(fmus["echo"], tmp_path / "echo.fmu", ("</ModelVariables>", f"{two}</ModelVariables>"))
    summary = simulate(load_system(fmu, EACH_MS).with_isolation("echo", False), tmp_path / "out", stop_time=0.01)
    assert any("twin: there twice" in text for text in summary.warnings)
    port = '<ScalarVariable name="y[1]" valueReference="903" causality="local"><Real/></ScalarVariable>'
    bad = altered(fmus["echo"], tmp_path / "bad.fmu", ("</ModelVariables>", f"{port}</ModelVariables>"))
    with pytest.raises(InputError, match=r"^bad: .*bad\.fmu has y\[1\] twice; names must be unique"):
        simulate(load_system(bad, EACH_MS), tmp_path / "no", stop_time=0.01)
