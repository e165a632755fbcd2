"""Step sizes, kinds and delays of files without annotations: their sources, refusals, and the command line."""

import zipfile

import h5py
import pytest
from fmpy.ssp.simulation import simulate_ssp

from flexbench.runs.export import export_run
from lockstep import InputError
from lockstep.cli.command import command
from lockstep.cli.run_options import folder_name
from lockstep.cli.timing_options import timing_options
from lockstep.plan.schedule import build_schedule
from lockstep.ssp.lone_fmu import lone_fmu
from lockstep.ssp.step_times import Timing
from lockstep.system.component import Component
from lockstep.system.system import System

MS = 1_000_000


def timing_of(*words):
    """Return the times of a command line."""
    parse = command("parse", "")(timing_options(lambda timing: timing.timing()))
    return parse.main(words, standalone_mode=False)


@pytest.fixture(scope="session")
def eager(fmus, tmp_path_factory):
    """Return the echo with a preferred step of 5 ms and outputs that change at steps alone."""
    path = tmp_path_factory.mktemp("eager") / "eager.fmu"
    with zipfile.ZipFile(fmus["echo"]) as source, zipfile.ZipFile(path, "w") as target:
        for member in source.infolist():
            content = source.read(member)
            if member.filename == "modelDescription.xml":
                text = content.decode().replace(
                    "<ModelVariables>", '<DefaultExperiment stepSize="0.005"/><ModelVariables>'
                )
                content = text.replace('causality="output"><Real', 'causality="output" variability="discrete"><Real')
                content = text.replace('causality="output">', 'causality="output" variability="discrete">').encode()
            target.writestr(member, content)
    return path


@pytest.fixture
def top(ssd, fmus, eager):
    """Return counter -> eager -> counter's sibling, whose kinds and periods differ."""
    counter = ssd.component("counter", fmus["counter"], "count output")
    echo = ssd.component("sub.eager", eager, "u[1] input", "y[1] output")
    plant = ssd.component("plant", fmus["integrator"], "u input", "x output")
    wires = ssd.connection("counter.count", "sub.eager/u[1]") + ssd.connection("sub.eager/y[1]", "plant.u")
    return ssd.system("top", counter + echo + plant, wires.replace('"counter.count', '"counter'))


def facts(system):
    return {c.name: (c.period, c.kind) for c in system.components}, [c.delay for c in system.connections], system.tick


def test_fmus_decide_what_the_command_line_leaves_open(load, top):
    parts, delays, tick = facts(load(top, timing_of("--step-size", "counter=0.002", "--step-size", "plant=0.003")))
    assert parts == {
        "counter": (2 * MS, "continuous"),
        "sub/eager": (5 * MS, "continuous"),  # discrete outputs too are true at the end of a step
        "plant": (3 * MS, "continuous"),
    }
    assert delays == [1, 1]  # the newest value: the one that is true at the start of the reader's step
    assert tick == MS  # the greatest of which all periods are multiples
    assert facts(load(top, timing_of("--sampled", "sub/eager")))[1] == [1, 0]  # of this tick from a sampled one


def test_discrete_outputs_are_recorded_at_the_end_of_the_step_however_the_system_is_made(load, ssd, eager):
    alone = lone_fmu(eager, Timing())
    assert [(c.kind, c.period) for c in alone.components] == [("continuous", 5 * MS)]
    text = ssd.system("top", ssd.component("eager", eager, "y[1] output"))
    bare = '<ssc:Annotation type="lockstep"><x:Component xmlns:x="urn:lockstep:1" period="0.005"/></ssc:Annotation>'
    annotated = text.replace("</ssd:Component>", f"<ssd:Annotations>{bare}</ssd:Annotations></ssd:Component>")
    made = System(name="api", tick=MS, components=(Component(name="eager", source=eager, period=5 * MS),))
    assert {c.kind for s in (load(text, Timing()), load(annotated, Timing()), made) for c in s.components} == {
        "continuous"
    }
    sampled = load(annotated.replace("period=", 'kind="sampled" period='), Timing())
    assert sampled.components[0].kind == "sampled"


def test_command_line_overrides_the_fmus(load, top):
    words = (
        "--step-size 0.002 --step-size sub/eager=0.004 --tick 0.001 --continuous sub/eager --sampled counter --delay 3"
    )
    parts, delays, tick = facts(load(top, timing_of(*words.split())))
    assert parts == {
        "counter": (2 * MS, "sampled"),
        "sub/eager": (4 * MS, "continuous"),
        "plant": (2 * MS, "continuous"),
    }
    assert (delays, tick) == ([3, 3], MS)


def test_annotations_override_the_fmus_and_hints_of_osp_their_steps(load, top):
    own = 'ssc:Annotation type="lockstep"><x:{} xmlns:x="urn:lockstep:1" {}/></ssc:Annotation>'
    hint = (
        'ssc:Annotation type="com.opensimulationplatform"><o:StepSizeHint value="0.02" '
        'xmlns:o="http://opensimulationplatform.com/SSP/OSPAnnotations"/></ssc:Annotation>'
    )

    def annotated(text, behind, *entries):
        head, found, tail = text.partition(behind)
        assert found
        end = tail.index("</ssd:Component>" if "Connector" in behind else "</ssd:Connection>")
        notes = "".join(f"<{entry}" for entry in entries)
        return f"{head}{found}{tail[:end]}<ssd:Annotations>{notes}</ssd:Annotations>{tail[end:]}"

    times = own.format("Component", 'period="0.01" kind="sampled" offset="0.005"')
    text = annotated(top, 'Connector name="count"', times, hint)
    text = annotated(text, 'Connector name="u[1]"', hint)
    text = annotated(text, 'startElement="counter"', own.format("Connection", 'delay="7"'))
    parts, delays, tick = facts(load(text, timing_of("--step-size", "plant=0.01")))
    assert parts == {
        "counter": (10 * MS, "sampled"),
        "sub/eager": (20 * MS, "continuous"),
        "plant": (10 * MS, "continuous"),
    }
    assert (delays, tick) == ([7, 1], 5 * MS)


@pytest.mark.parametrize(
    "step",
    [
        '<Annotations xmlns="urn:o"><Information><FixedStepMaster stepSize="0.008000"/></Information>'
        "</Annotations>",  # as OMSimulator writes it
        '<Algorithm xmlns="urn:o"><FixedStepAlgorithm baseStepSize="8e-3"/></Algorithm>',  # OSP
    ],
)
def test_step_of_another_master_overrides_those_of_the_fmus(load, top, step):
    note = f'<ssd:Annotations><ssc:Annotation type="other">{step}</ssc:Annotation></ssd:Annotations>'
    text = top.replace("</ssd:System>", f"{note}</ssd:System>")
    parts, _, tick = facts(load(text, timing_of("--step-size", "plant=0.004")))
    assert [period for period, _ in parts.values()] == [8 * MS, 8 * MS, 4 * MS]
    assert tick == 4 * MS


def test_without_any_step_size_it_is_the_smallest_of_the_others_or_a_millisecond(load, top, ssd, fmus):
    text = "neither the file nor the FMU gives a step size: stepped every"
    system = load(top, timing_of("--step-size", "sub/eager=0.0005"))
    assert f"counter, plant: {text} 0.0005 s; --step-size changes it" in system.warnings
    assert {part.period for part in system.components} == {MS // 2}
    alone = load(ssd.system("top", ssd.component("counter", fmus["counter"])), timing_of())
    assert f"counter: {text} 0.001 s; --step-size changes it" in alone.warnings
    assert alone.components[0].period == MS


REFUSED = [
    (
        ("--step-size", "0.001", "--step-size", "eager=1"),
        r"^eager: no such component; there are counter, sub/eager, plant",
    ),
    (("--step-size", "0.001", "--sampled", "plnt"), r"^--sampled plnt: no such component; .*did you mean plant\?"),
    (("--step-size", "0"), r"^--step-size 0: must be > 0 s"),
    (("--step-size", "1", "--step-size", "2"), r"^--step-size 2: given for all already, as 1; name a component"),
    (("--step-size", "0.3 s"), r"^--step-size: '0\.3 s' is not a number of seconds"),
    (("--tick", "-1"), r"^--tick -1: must be > 0 s"),
    (("--delay", "x"), r"^--delay x: write FROM:TO=TICKS"),
    (("--delay", "1", "--delay", "2"), r"^--delay 2: given for all already"),
    (("--sampled", "plant", "--continuous", "plant"), r"^--sampled plant: --continuous names it too; choose one"),
]


@pytest.mark.parametrize(("words", "message"), REFUSED)
def test_wrong_times_are_refused_in_one_line(load, top, words, message):
    with pytest.raises(InputError, match=message):
        load(top, timing_of(*words))


def test_an_odd_step_of_an_fmu_is_refused_with_the_remedy(tmp_path, ssd, load, eager):
    odd = tmp_path / "odd.fmu"
    with zipfile.ZipFile(eager) as source, zipfile.ZipFile(odd, "w") as target:
        for member in source.infolist():
            target.writestr(member, source.read(member).replace(b'stepSize="0.005"', b'stepSize="0.00333333333"'))
    with pytest.raises(
        InputError, match=r"odd: the FMU's step size: 0\.00333333333 s is not .*; give --step-size odd=S"
    ):
        load(ssd.system("top", ssd.component("odd", odd)), Timing())


def test_a_cycle_of_sampled_components_is_printed_with_its_members(ssd, load, eager):
    parts = "".join(ssd.component(name, eager, "u[1] input", "y[1] output") for name in ("one", "two"))
    wires = ssd.connection("one.y[1]", "two.u[1]") + ssd.connection("two.y[1]", "one.u[1]")
    text = ssd.system("top", parts, wires)
    with pytest.raises(InputError, match=r"cycle: one -> two -> one; .* such as --delay one:two=1$"):
        build_schedule(load(text, timing_of("--sampled", "one", "--sampled", "two")))
    build_schedule(load(text, timing_of("--sampled", "one", "--sampled", "two", "--delay", "1")))
    build_schedule(load(text, timing_of("--sampled", "one")))
    build_schedule(load(text, Timing()))


@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("slew-1 (a)", "slew-1 _a_"),
        ("../../etc/x", "_.._etc_x"),
        ("..", "system"),
        ("/a", "_a"),
        ("Übung 3", "Übung 3"),
    ],
)
def test_results_stay_below_their_folder_for_any_system_name(name, folder):
    assert folder_name(name) == folder


def test_command_line_shows_and_runs_a_system_without_annotations(tmp_path, ssd, top, cli):
    path = tmp_path / "foreign.ssd"
    path.write_text(ssd.document(top))
    words = ("--step-size", "0.001", "--delay", "2", "--delay", "counter:sub/eager=5", "--sampled", "sub/eager")
    shown = cli("show", path, *words)
    assert (shown.returncode, shown.stderr) == (0, "")
    assert "sub/eager  every 0.001 s from 0 s, sampled, eager.fmu" in shown.stdout
    assert "counter -> sub/eager: 1 value, delay 5 ticks" in shown.stdout
    assert "sub/eager -> plant: 1 value, delay 2 ticks" in shown.stdout
    values = ("--set", "sub/eager.u[2]=1", "--set", "sub/eager.flag=true", "--set", "sub/eager.number=3")
    shared = [word for name in ("counter", "sub/eager", "plant") for word in ("--share-process", name)]
    done = cli("run", path, *words, *values, *shared, "--record", "sub/eager.*", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "run" / "run.toml").read_text()
    assert 'from = "counter"\nto = "sub/eager"\ndelay = 5' in text
    export_run(tmp_path / "run", "hdf5", tmp_path / "run.h5", None)
    with h5py.File(tmp_path / "run.h5") as file:
        assert "sub.eager.y" in file  # a slash would make a group of it


def test_without_annotations_the_values_are_those_of_fmpys_master(tmp_path, ssd, fmus, load, run, pack):
    """FMPy's simulate_ssp steps all with what is true at the start of a step, as we do by default."""
    echo = ssd.component("echo", "resources/echo.fmu", "u[1] input", "y[1] output", "number input Integer",
                         "number_out output Integer")  # fmt: skip
    link = ssd.connection
    sub = ssd.system(
        "sub", echo,
        link(".u", "echo.u[1]") + link("echo.y[1]", ".y") + link(".n", "echo.number"),
        ("u input", "y output", "n input Integer"),
    )  # fmt: skip
    counter = ssd.component("counter", "resources/counter.fmu", "count output", "steps output Integer")
    plant = ssd.component("plant", "resources/integrator.fmu", "u input", "x output")
    wires = link("counter.count", "sub.u") + link("counter.steps", "sub.n") + link("sub.y", "plant.u")
    text = ssd.system("top", counter + sub + plant, wires)
    members = {f"resources/{name}.fmu": fmus[name].read_bytes() for name in ("counter", "echo", "integrator")}
    package = pack(tmp_path / "p.ssp", {"SystemStructure.ssd": ssd.document(text), **members})
    step = 2.0**-9  # s: sums of it are exact, as FMPy adds them up; and it is a whole number of ns
    fmpys = simulate_ssp(str(package), stop_time=32 * step, step_size=step)
    for name in ("counter", "echo", "integrator"):
        text = text.replace(f"resources/{name}.fmu", str(fmus[name]))
    system = load(text, timing_of("--step-size", str(step)), stop=32 * step)
    found = run(system, overrides={"sub/echo.u[2]": 0, "sub/echo.flag": False})
    for name, other in (("counter.count", "counter.count"), ("sub/echo.y[1]", "sub.echo.y[1]"),
                        ("sub/echo.number_out", "sub.echo.number_out"), ("plant.x", "plant.x")):  # fmt: skip
        assert len(fmpys[other]) == 32
        assert (found[name][1:] == fmpys[other]).all()  # FMPy records the values of the end of a step at its start
    assert found["plant.x"][-1] > 0
