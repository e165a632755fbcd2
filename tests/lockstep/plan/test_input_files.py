"""Files of signals for inputs: how values follow from rows, and what is refused."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from fmus.echo_fmu import echo_fmu
from lockstep import Component, Connection, InputError, System, read_signals, resume, simulate
from lockstep.__main__ import main
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.system.system import Feed, SystemInput
from lockstep.system.transformation import Hop
from lockstep.system.units import Unit

MS = 1_000_000  # [ns]


@pytest.fixture(scope="module")
def echo(tmp_path_factory) -> Path:
    return echo_fmu(tmp_path_factory.mktemp("echo"))


@pytest.fixture
def system(echo) -> System:
    component = Component(name="echo", source=echo, period=MS, kind="continuous", isolated=False)
    return System(name="one", tick=MS, components=(component,), path=echo)


def _written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


SIGNALS = """Time, echo.x ,echo.h,echo.n,echo.b,echo.s
0.001,1,1,1,true,"a, b"
0.003,3,3,3,0,c
0.0040000000000000001,7,4,4,1.0,d
0.004,9,5,5,false,e
"""


def test_reals_are_interpolated_and_all_else_is_held(system, tmp_path):
    simulate(
        system, tmp_path / "run", stop_time=0.006, inputs=_written(tmp_path / "in.csv", SIGNALS), record=["inputs:*"]
    )
    run = read_signals(tmp_path / "run")
    assert list(run.time[:6]) == [0.0, 0.001, 0.002, 0.003, 0.004, 0.005]
    # before the first row its values, after the last row those of that; of two rows at 4 ms the second one
    assert list(run["echo.x"][:6]) == [1.0, 1.0, 2.0, 3.0, 9.0, 9.0]
    assert list(run["echo.h"][:6]) == [1.0, 1.0, 1.0, 3.0, 5.0, 5.0]
    assert list(run["echo.n"][:6]) == [1, 1, 1, 3, 5, 5]
    assert list(run["echo.b"][:6]) == [1, 1, 1, 0, 0, 0]
    assert list(run["echo.s"][:6]) == ["a, b", "a, b", "a, b", "c", "e", "e"]


def test_a_step_holds_the_value_at_its_start(system, tmp_path):
    simulate(system, tmp_path / "run", stop_time=0.006, inputs=[_written(tmp_path / "in.csv", SIGNALS)])
    run = read_signals(tmp_path / "run")
    assert list(run["echo.out.x"][1:6]) == [1.0, 1.0, 2.0, 3.0, 9.0]  # true at the end of the step
    assert list(run["echo.out.s"][1:6]) == ["a, b", "a, b", "a, b", "c", "e"]


def test_initial_outputs_are_those_of_the_inputs_at_the_start(system, tmp_path):
    simulate(system, tmp_path / "run", stop_time=0.001, inputs=[_written(tmp_path / "in.csv", SIGNALS)])
    assert read_signals(tmp_path / "run")["echo.out.x"][0] == 1.0


def test_parquet_gives_the_same_and_its_units_are_converted(system, tmp_path):
    fields = [pa.field("time", pa.float64()), pa.field("echo.x", pa.float64(), metadata={"unit": "rad"})]
    fields += [pa.field("echo.n", pa.float64()), pa.field("echo.b", pa.bool_()), pa.field("echo.s", pa.string())]
    rows = [[0.0, 0.002], [0.0, np.pi], [1.0, 2.0], [True, False], ["a", "b"]]
    pq.write_table(
        pa.table([pa.array(v, f.type) for v, f in zip(rows, fields, strict=True)], pa.schema(fields)), tmp_path / "in"
    )
    simulate(system, tmp_path / "run", stop_time=0.003, inputs=tmp_path / "in", record=["inputs:*"])
    run = read_signals(tmp_path / "run")
    assert np.allclose(run["echo.x"][:3], [0.0, 90.0, 180.0], rtol=1e-15)
    assert (list(run["echo.n"][:3]), list(run["echo.b"][:3])) == ([1, 1, 2], [1, 1, 0])
    assert list(run["echo.s"][:3]) == ["a", "a", "b"]


def test_csv_columns_may_state_units_as_exported_results_do(system, tmp_path):
    file = _written(tmp_path / "in.csv", f"time [s],echo.x [rad],echo.h [1],echo.n\n0,{np.pi!r},2,3\n")
    simulate(system, tmp_path / "run", stop_time=0.002, inputs=file, record=["inputs:*"])
    run = read_signals(tmp_path / "run")
    assert (run["echo.x"][0], run["echo.h"][0], run["echo.n"][0]) == (pytest.approx(180.0, rel=1e-15), 2.0, 3)


def test_one_fmu_alone_takes_names_of_its_variables_and_other_delimiters(echo, tmp_path, capsys):
    for number, delimiter in enumerate(",;\t"):
        text = delimiter.join(("time", "x")) + "\n" + delimiter.join(("0", "5")) + "\n"
        out = tmp_path / str(number)
        arguments = [str(echo), "--input", str(_written(tmp_path / "in.csv", text)), "--stop-time", "0.002"]
        assert main(["run", *arguments, "--share-process", "echo", "--step-size", "0.001", "--out", str(out)]) == 0
        assert read_signals(out)["echo.out.x"][1] == 5.0
    kept = capsys.readouterr().err
    assert "keep their start values: echo.h, n, b, s" in kept


def test_a_connector_of_the_system_converts_as_its_connections_do(system, tmp_path):
    radians = Unit(name="rad", exponents=(0, 0, 0, 0, 0, 0, 0, 1))
    feeds = (
        Feed(component="echo", input="x", hops=(Hop(factor=2.0, offset=1.0),)),
        Feed(component="echo", input="h", hops=(Hop(),)),
    )
    fed = replace(
        system,
        inputs=(
            SystemInput(name="angle", unit=radians, feeds=feeds[:1]),
            SystemInput(name="level", unit=None, feeds=feeds[1:]),
        ),
    )
    text = f"time,angle,level\n0,{np.pi!r},4\n"
    simulate(fed, tmp_path / "run", stop_time=0.002, inputs=_written(tmp_path / "in.csv", text), strict_inputs=False)
    run = read_signals(tmp_path / "run")
    assert run["echo.out.x"][1] == pytest.approx(361.0, rel=1e-15)
    assert run["echo.out.h"][1] == 4.0


REFUSED = (
    ("echo.x\n1\n", "in.csv: has 0 columns time, and needs one, in seconds; it has echo.x"),
    ("time [ms],echo.x\n1,1\n", "in.csv: has its time in ms; give seconds"),
    ("time,echo.x [m]\n1,1\n", "in.csv: column echo.x: unit 'm' [m] does not convert to 'deg' [1]"),
    ("time\n1\n", "in.csv: has no column beside time"),
    ("time,echo.y\n0,1\n", "in.csv: column echo.y: echo.y: no such input"),
    ("time,ech.x\n0,1\n", "in.csv: column ech.x: echo.ech.x: no such input"),
    ("time,echo.gain\n0,1\n", "in.csv: column echo.gain: is the FMU's parameter, and files feed inputs only; --set"),
    ("time,echo.out.x\n0,1\n", "in.csv: column echo.out.x: is the FMU's output"),
    ("time,echo.x,x\n0,1,2\n", "in.csv: column x: echo.x is fed by in.csv: column echo.x already"),
    ("time,echo.x,echo.x\n0,1,2\n", "in.csv: has the column echo.x twice"),
    ("time,echo.x\n", "in.csv: has no rows"),
    ("time,echo.x\n0,1\n1,\n", "in.csv: row 2: echo.x is empty"),
    ("time,echo.x\n0,1\n1,nan\n", "in.csv: row 2: echo.x nan must be finite"),
    ("time,echo.x\n0,one\n", "in.csv: cannot be read (In CSV column #1: CSV conversion error to double: invalid"),
    ("time,echo.x\n1,1\n0,1\n", "in.csv: row 2: time 0 s after 1 s; sort the rows"),
    ("time,echo.n\n0,1.5\n", "in.csv: row 1: echo.n: '1.5' is not of its type Integer"),
    ("time,echo.n\n0,1\n1,10\n", "in.csv: row 2: echo.n: 10 is outside [-inf, 9.0]"),
    ("time,echo.b\n0,maybe\n", "in.csv: row 1: echo.b: 'maybe' is not of its type Boolean; write true or false"),
)  # fmt: skip


@pytest.mark.parametrize(("text", "message"), REFUSED, ids=range(len(REFUSED)))
def test_bad_file_is_refused_in_one_line(text, message, system, tmp_path):
    with pytest.raises(InputError) as refused:
        simulate(system, tmp_path / "run", stop_time=0.002, inputs=_written(tmp_path / "in.csv", text))
    assert str(refused.value).startswith(message)
    assert not (tmp_path / "run").exists()


def test_connected_or_set_input_is_refused(echo, tmp_path):
    components = [Component(name=n, source=echo, period=MS, kind="continuous", isolated=False) for n in ("a", "b")]
    link = Connection(from_component="a", output="out.x", to_component="b", input="x", delay=1)
    system = System(name="two", tick=MS, components=tuple(components), connections=(link,))
    file = _written(tmp_path / "in.csv", "time,b.x\n0,1\n")
    with pytest.raises(InputError, match=r"column b\.x: b\.x is connected to a\.out\.x; remove the column"):
        simulate(system, tmp_path / "run", inputs=file)
    file.write_text("time,b.h\n0,1\n")
    with pytest.raises(InputError, match=r"in\.csv: column b\.h: b\.h has a value by b\.h; give one"):
        simulate(system, tmp_path / "run", inputs=file, overrides={"b.h": 2.0})
    with pytest.raises(InputError, match=r"none\.csv: cannot be read \(No such file or directory\)"):
        simulate(system, tmp_path / "run", inputs=tmp_path / "none.csv")


def test_resumed_run_and_branch_keep_the_file_and_refuse_a_changed_one(system, tmp_path):
    text = "time,echo.x,echo.h\n0,0,0\n0.01,10,0\n0.01,10,8\n"
    file, schedule = _written(tmp_path / "in.csv", text), CheckpointSchedule(times=("0.004",))
    whole, killed, branch = (tmp_path / name for name in ("whole", "killed", "branch"))

    def stop(time: float, _: float) -> None:
        if time > 0.005:
            raise KeyboardInterrupt

    simulate(system, whole, stop_time=0.012, inputs=file, checkpoints=schedule)
    saved = whole / "checkpoints" / "t=0.004.ckpt"
    simulate(system, branch, restart=Restart(checkpoint=read_checkpoint(saved)))
    rows = read_signals(branch)
    assert list(rows["echo.out.x"][1:8]) == pytest.approx([4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0], rel=1e-15)
    noted = tomllib.loads((branch / "run.toml").read_text())["inputs"]
    assert noted == tomllib.loads((whole / "run.toml").read_text())["inputs"]
    assert (noted[0]["path"], noted[0]["columns"]) == (str(file), ["echo.x", "echo.h"])

    simulate(system, killed, stop_time=0.012, inputs=file, checkpoints=schedule)
    record = (killed / "run.toml").read_text().replace('status = "completed"', 'status = "interrupted"')
    (killed / "run.toml").write_text(record)
    resume(killed, system)
    one, other = read_signals(whole), read_signals(killed)
    assert all(np.array_equal(one[name], other[name]) for name in one.columns)

    file.write_text(text + "0.02,1,1\n")
    with pytest.raises(InputError, match=r"in\.csv: has changed since the run, sha256 .*; restore the old one"):
        simulate(system, tmp_path / "other", restart=Restart(checkpoint=read_checkpoint(saved)))
    other_file = _written(tmp_path / "new.csv", "time,echo.x\n0,3\n")
    simulate(system, tmp_path / "new", restart=Restart(checkpoint=read_checkpoint(saved)), inputs=other_file)
    assert list(read_signals(tmp_path / "new")["echo.out.x"][1:3]) == [3.0, 3.0]
