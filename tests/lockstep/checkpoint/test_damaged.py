"""Checkpoints whose header or arrays were changed, in a whole zip file: refused by name, before anything changes."""

import io
import json
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from lockstep import InputError, simulate
from lockstep.checkpoint.file import newest_checkpoint, read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.simulation import resume


def rewritten(path, target, header=None, arrays=None):
    """Write a checkpoint with a changed header, and arrays: functions that change them in place."""
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "header.json" and header is not None:
                found = json.loads(content)
                header(found)
                content = json.dumps(found)
            if name == "arrays.npz" and arrays is not None:
                with np.load(io.BytesIO(content)) as saved:
                    values = dict(saved)
                arrays(values)
                packed = io.BytesIO()
                np.savez(packed, **values)
                content = packed.getvalue()
            new.writestr(name, content)
    return target


def put(*keys, value):
    """Return a function that sets an item of tables in tables."""

    def change(content):
        *path, last = keys
        for key in path:
            content = content[key]
        content[last] = value

    return change


def cut(name, count=-1):
    return lambda arrays: arrays.update({name: arrays[name][:count]})


HEADERS = [
    (
        put("tick", value=-5),
        r"tick = -5 of 1000000 ns and time = 31000000 ns do not agree, or are < 0",
    ),
    (put("time", value=32_000_000), r"tick = 31 of 1000000 ns and time = 32000000 ns do not agree"),
    (put("tick", value="31"), r"tick = '31' must be a whole number"),
    (put("identity", "tick", value=0), r"tick = 31 of 0 ns"),
    (put("rows", value=-1), r"rows = -1 must be >= 0"),
    (put("rows", value=1e300), r"rows = 1e\+300 must be a whole number"),
    (put("wall_time", value=float("nan")), r"wall_time = nan must be >= 0"),
    (put("events", value=[]), r"events = \[\] must be a table"),
    (put("events", "size", value=-1), r"events.size = -1 must be >= 0"),
    (put("run", "component", value=5), r"run.component = 5 must be a list"),
    (put("run", "system", "path", value=None), r"run.system.path = None must be a text"),
    (put("outputs", "a", value=["y"]), r"outputs.a = \['y'\] must be a table"),
    (put("outputs", "a", "Real", value=[]), r"its array bus/a/Real/output does not number the outputs \[\]"),
    (put("outputs", "a", "Complex", value=["y"]), r"outputs.a: 'Complex' is no type of values"),
    (lambda header: header.pop("checkpoints"), r"checkpoints is missing"),
    (put("faults", value={"memory": 1}), r"faults.memory = 1 must be a list"),
]
ARRAYS = [
    (cut("bus/a/Real/value"), r"its arrays bus/a/Real/version, .* have \[\d+, \d+, \d+\] elements"),
    (lambda arrays: arrays.pop("bus/p/Real/output"), r"its array bus/p/Real/output is missing"),
    (lambda arrays: arrays.pop("rows/waiting"), r"its array rows/waiting is missing"),
    (put("bus/a/Real/value", value=np.array([[1.0]])), r"its array bus/a/Real/value is of shape \(1, 1\)"),
    (put("bus/a/Real/value", value=np.array(["x"])), r"its array bus/a/Real/value is of shape \(1,\) and type <U1"),
    (put("rows/waiting", value=np.zeros(9)), r"its array rows/waiting is of shape \(9,\) and type float64"),
]


@pytest.mark.parametrize(("change", "message"), HEADERS)
def test_a_changed_header_is_refused(whole, tmp_path, change, message):
    path = rewritten(newest_checkpoint(whole), tmp_path / "bad.ckpt", header=change)
    with pytest.raises(InputError, match=rf"bad\.ckpt: is a damaged checkpoint: .*{message}.*; use another one"):
        read_checkpoint(path)


@pytest.mark.parametrize(("change", "message"), ARRAYS)
def test_arrays_that_are_cut_are_refused(whole, tmp_path, change, message):
    path = rewritten(newest_checkpoint(whole), tmp_path / "bad.ckpt", arrays=change)
    with pytest.raises(InputError, match=rf"bad\.ckpt: is a damaged checkpoint: .*{message}.*; use another one"):
        read_checkpoint(path)


@pytest.mark.parametrize("text", ["[" * 100_000, "[1]", "{", "\xff"])
def test_a_header_that_is_no_table_is_refused(tmp_path, text):
    with zipfile.ZipFile(tmp_path / "bad.ckpt", "w") as archive:
        archive.writestr("header.json", text)
        archive.writestr("arrays.npz", b"")
    with pytest.raises(InputError, match=r"bad\.ckpt: (header\.json: is|is no checkpoint).*"):
        read_checkpoint(tmp_path / "bad.ckpt")


@pytest.fixture
def ended(triple, whole, tmp_path):
    """Return a function that makes a folder of a failed run with a changed checkpoint, and resumes it."""

    def go(*, header=None, arrays=None):
        out = tmp_path / "out"
        (out / "checkpoints").mkdir(parents=True)
        for name in ("run.toml", "events.jsonl", "signals.parquet"):
            if not (out / name).exists():
                (out / name).write_bytes((whole / name).read_bytes())
        run = (out / "run.toml").read_text()
        (out / "run.toml").write_text(run.replace('"completed"', '"failed"'))
        good = newest_checkpoint(whole)
        rewritten(good, out / "checkpoints" / good.name, header, arrays)
        before = {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}
        try:
            resume(out, triple)
        finally:
            if header or arrays:
                assert {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()} == before
        return out

    return go


def test_a_run_resumes_from_a_checkpoint_that_was_only_packed_again(ended, whole):
    assert (ended() / "signals.parquet").read_bytes() == (whole / "signals.parquet").read_bytes()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"arrays": cut("rows/waiting", 200)}, r"is a damaged checkpoint \(its waiting rows cannot be read: .*"),
        ({"header": put("rows", value=3)}, r"t=0\.031\.ckpt: has 34 rows of 31 until its time; use another one"),
    ],
)  # fmt: skip
def test_rows_that_do_not_fit_are_refused_before_anything_changes(ended, changes, message):
    with pytest.raises(InputError, match=message):
        ended(**changes)


def test_events_that_were_cut_are_refused_and_not_filled_with_zeros(ended, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out/events.jsonl").write_text('{"time": 0.0, "event": "start"}\n')
    message = r"events\.jsonl: has 32 bytes, and t=0\.031\.ckpt needs \d+; restore it, or remove that checkpoint"
    with pytest.raises(InputError, match=message):
        ended()


def test_a_state_that_is_cut_is_refused_by_the_name_of_its_component(triple, whole, tmp_path):
    found = read_checkpoint(newest_checkpoint(whole))
    states = {name: dict(files) for name, files in found.states.items()}
    (file,) = states["b"]
    states["b"][f"{file}.other"] = states["b"].pop(file)
    restart = Restart(checkpoint=replace(found, states=states))
    with pytest.raises(InputError, match=r"is a damaged checkpoint \(the state of b: FileNotFoundError.*; use another"):
        simulate(triple, tmp_path / "branch", restart=restart)
    assert not (tmp_path / "branch").exists()
