"""Start values reach FMUs that reset all variables when the experiment is set up, and the tolerance reaches all FMUs.

The FMU of `fmus.setup` gives y = p, v = u and the tolerance that it was passed; its fmi2SetupExperiment resets p and u,
as that of 20-sim's generated code does.
"""

import shutil
import tomllib
from dataclasses import replace

import pytest

from fmus.setup.setup_fmu import setup_fmu
from lockstep import Component, Connection, InputError, RunOptions, System, read_signals, resume, simulate, write_ssd
from lockstep.__main__ import main
from lockstep.adapter.component import replace_component
from lockstep.adapter.read import read_adapter
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.shadow.component import with_shadow

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the FMUs are compiled with gcc")
STEP = 10_000_000  # [ns]


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """Return the FMU of FMI 2.0, which declares 1e-7, and that of FMI 3.0, which declares no tolerance."""
    folders = [tmp_path_factory.mktemp(f"fmi{fmi}") for fmi in (2, 3)]
    return setup_fmu(folders[0], tolerance="1e-7"), setup_fmu(folders[1], fmi=3)


@pytest.fixture
def system(fmus):
    """Return the FMU of FMI 2.0 as `s`, which feeds another one, `reader`; and that of FMI 3.0 as `newer`."""
    s = Component(
        name="s", source=fmus[0], period=STEP, kind="sampled", parameters={"u": 4.0, "whole": 9}, isolated=False
    )
    newer = Component(name="newer", source=fmus[1], period=STEP, kind="sampled", parameters={"p": 2.5}, isolated=False)
    reader = Component(name="reader", source=fmus[0], period=STEP, kind="sampled", isolated=False)
    wire = Connection(from_component="s", output="y", to_component="reader", input="u")
    return System(name="setup", tick=STEP, stop_time=6 * STEP, components=(s, newer, reader), connections=(wire,))


def last(folder, *names):
    """Return the last recorded values of signals."""
    signals = read_signals(folder)
    return [signals[name][-1] for name in names]


def component_of(folder, name):
    """Return what run.toml says of a component."""
    record = tomllib.loads((folder / "run.toml").read_text())
    return next(entry for entry in record["component"] if entry["name"] == name)


@pytest.mark.parametrize("isolated", [False, True], ids=["inside", "isolated"])
def test_start_values_and_tolerance_reach_fmus_in_any_process(system, tmp_path, isolated):
    system = replace(system, components=tuple(replace(c, isolated=isolated) for c in system.components))
    simulate(system, tmp_path / "out", overrides={"s.p": 1.0}, tolerance={"newer": 1e-4})

    names = ("s.y", "s.v", "s.shown", "reader.y", "reader.v", "newer.y")
    assert last(tmp_path / "out", *names) == [1.0, 4.0, 9, 0.5, 1.0, 2.5]
    assert last(tmp_path / "out", "s.tolerance", "newer.tolerance") == [1e-7, 1e-4]


def test_declared_tolerance_is_passed_unless_another_one_is_given(system, tmp_path):
    tolerances = [f"{name}.tolerance" for name in ("s", "reader", "newer")]
    simulate(system, tmp_path / "declared")
    simulate(system, tmp_path / "given", tolerance="1e-3")
    simulate(system, tmp_path / "one", tolerance={"newer": 1e-4})

    assert last(tmp_path / "declared", *tolerances) == [1e-7, 1e-7, -1.0]
    assert last(tmp_path / "given", *tolerances) == [1e-3] * 3
    assert last(tmp_path / "one", *tolerances) == [1e-7, 1e-7, 1e-4]
    assert component_of(tmp_path / "one", "s")["tolerance"] == 1e-7
    assert "tolerance" not in component_of(tmp_path / "declared", "newer")


def test_constants_and_parameters_of_an_adapter_outlast_it(system, fmus, tmp_path):
    (tmp_path / "a.toml").write_text(
        'ignore = ["tolerance"]\n'
        + "".join(f'[[output]]\nport = "{name}"\nvariable = "{name}"\n' for name in ("y", "v", "shown"))
        + "[constants]\nu = 4.0\n[parameters]\np = 2.0\n"
    )
    system = replace_component(system, "s", fmus[0], read_adapter(tmp_path / "a.toml"))
    simulate(system, tmp_path / "file")
    simulate(system, tmp_path / "set", overrides={"s.p": 3.0})

    assert last(tmp_path / "file", "s.y", "s.v", "s.shown") == [2.0, 4.0, 9]
    assert last(tmp_path / "set", "s.y", "s.v", "s.shown") == [3.0, 4.0, 9]


def test_shadow_gets_start_values_and_its_own_tolerance(system, fmus, tmp_path):
    parts = tuple(replace(c, kind="sampled") for c in system.components if c.name != "newer")  # which saves no state
    shadowed = with_shadow(replace(system, components=parts), "s", fmus[0])
    given = RunOptions(overrides={"s.p": 1.0, "s.u": 2.0}, record=["all"], tolerance={"s": 1e-2})
    simulate(shadowed, tmp_path / "out", given, checkpoints=CheckpointSchedule(times=["0.03"]))

    assert last(tmp_path / "out", "s.original.y", "s.shadow.y", "reader.v") == [1.0, 1.0, 1.0]
    assert component_of(tmp_path / "out", "s")["tolerance"] == 1e-2
    assert component_of(tmp_path / "out", "s")["shadow"]["tolerance"] == 1e-7
    restart = Restart(checkpoint=read_checkpoint(tmp_path / "out/checkpoints/t=0.03.ckpt"))
    with pytest.raises(
        InputError, match=r"was made with another tolerance of the shadow, 1e-07, not 0.5; give the same"
    ):
        simulate(shadowed, tmp_path / "other", restart=restart, tolerance={"s_shadow": 0.5})


def test_restarted_runs_keep_start_values_and_tolerance(system, tmp_path):
    system = replace(system, components=(system.components[0], system.components[2]))
    saves = CheckpointSchedule(times=["0.03"])
    names = ("s.y", "s.v", "s.shown", "s.tolerance", "reader.v")
    simulate(system, tmp_path / "whole", overrides={"s.p": 1.0}, tolerance=1e-3, checkpoints=saves)
    checkpoint = read_checkpoint(tmp_path / "whole/checkpoints/t=0.03.ckpt")
    simulate(system, tmp_path / "branch", restart=Restart(checkpoint=checkpoint), overrides={"s.u": 5.0})
    again = Restart(checkpoint=checkpoint, reinitialised=("s",))
    simulate(system, tmp_path / "again", restart=again, overrides={"s.p": 2.0})
    record = tmp_path / "whole/run.toml"
    record.write_text(record.read_text().replace('status = "completed"', 'status = "interrupted"'))
    resume(tmp_path / "whole", system)

    assert last(tmp_path / "whole", *names) == [1.0, 4.0, 9, 1e-3, 1.0]
    assert last(tmp_path / "branch", *names) == [1.0, 5.0, 9, 1e-3, 1.0]
    assert last(tmp_path / "again", *names) == [2.0, 4.0, 9, 1e-7, 2.0]
    assert component_of(tmp_path / "branch", "s")["tolerance"] == 1e-3
    with pytest.raises(InputError, match=r"^s: t=0.03.ckpt was made with another tolerance, 0.001, not 0.5; give the"):
        simulate(system, tmp_path / "other", restart=Restart(checkpoint=checkpoint), tolerance=0.5)


def test_command_line_takes_a_tolerance_for_all_and_for_one(system, tmp_path, capsys):
    path = tmp_path / "setup.ssd"
    first, *others = system.components
    write_ssd(replace(system, components=(replace(first, tolerance=1e-2), *others)), path)

    def run(*options):
        return main(["run", str(path), "--out", str(tmp_path / "out"), *options])

    assert run("--tolerance", "1e-5", "--tolerance", "newer=1e-4", "--set", "s.p=1") == 0
    assert last(tmp_path / "out", "s.y", "s.tolerance", "reader.tolerance", "newer.tolerance") == [
        1.0, 1e-5, 1e-5, 1e-4
    ]  # fmt: skip
    assert run("--overwrite") == 0
    assert last(tmp_path / "out", "s.tolerance", "reader.tolerance", "newer.tolerance") == [1e-2, 1e-7, -1.0]
    capsys.readouterr()
    for texts, message in (
        (("s=0",), "s: tolerance 0.0 must be a number > 0, for example 1e-6"),
        (("nan",), "s: tolerance nan must be a number > 0, for example 1e-6"),
        (("small",), "s: tolerance 'small' must be a number > 0, for example 1e-6"),
        (("x=1e-3",), "x: no such component; there are s, newer, reader"),
        (("1e-3", "1e-4"), "--tolerance 1e-4: write COMPONENT=TOLERANCE or TOLERANCE for all, each once"),
    ):
        code = main(["run", str(path), "--out", str(tmp_path / "no"), *(f"--tolerance={text}" for text in texts)])
        assert code == 2
        assert message in capsys.readouterr().err
        assert not (tmp_path / "no").exists()


def test_tolerance_is_refused_where_it_cannot_be_passed(reference_fmu, tmp_path):
    old = Component(name="old", source=reference_fmu("stair", "1.0"), period=STEP, kind="sampled")
    with pytest.raises(InputError, match=r"^old: tolerance 0.001: FMI 1.0 cannot pass a tolerance; name the others"):
        simulate(System(name="s", tick=STEP, stop_time=STEP, components=(old,)), tmp_path / "out", tolerance=1e-3)
