"""FMUs that stay loaded between runs: the rows of each run are those of a new FMU."""

import numpy as np
import pytest

from fmus.wanderer.wanderer import wanderer
from lockstep import Component, System, simulate
from lockstep.fmi.kept_fmus import KeptFmus
from lockstep.fmi.model_description import read_description

START = {"u": 1.0, "offset": 0.0, "number": 0, "flag": False}


def system(fmu):
    """Return a system of one FMU in this process."""
    part = Component(name="a", source=fmu, period=1_000_000, kind="sampled", isolated=False, parameters=START)
    return System(name="one", tick=1_000_000, stop_time=10**7, components=(part,), connections=())


def runs(of, kept):
    """Return the rows of three runs, of which the second sets parameters."""
    found = []
    for overrides in ({}, {"a.seed": 7, "a.gain": 2.0}, {}):
        signals = simulate(of, overrides=overrides, kept=kept).signals
        found.append(np.column_stack([signals[name] for name in ("a.y", "a.steps", "a.began")]))
    return found


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Return FMUs that can be reset, cannot, and cannot but say so."""
    folder = tmp_path_factory.mktemp("fmus")
    return {name: wanderer(folder, name, *defines) for name, *defines in (("resets", "RESETS"), ("not",),
                                                                         ("forgets", "FORGETS"))}  # fmt: skip


@pytest.mark.parametrize(("name", "unpacked"), [("resets", 1), ("not", 3)])
def test_runs_are_those_of_new_instances(built, tmp_path, name, unpacked):
    kept = KeptFmus(tmp_path)
    found, expected = runs(system(built[name]), kept), runs(system(built[name]), None)

    assert all(np.array_equal(*both) for both in zip(found, expected, strict=True))
    assert len(list(tmp_path.iterdir())) == unpacked
    kept.close()


def test_an_fmu_that_keeps_something_is_noticed_by_its_rows(built, tmp_path):
    kept = KeptFmus(tmp_path)
    found, expected = runs(system(built["forgets"]), kept), runs(system(built["forgets"]), None)

    assert np.array_equal(found[0], expected[0])
    assert not np.array_equal(found[2], expected[2])
    kept.close()


def test_what_runs_bound_is_released(built, tmp_path):
    """Else each run would leave the memory of its getters and setters behind."""
    kept = KeptFmus(tmp_path)
    runs(system(built["resets"]), kept)
    ((slave, _),) = next(iter(kept._idle.values()))

    assert slave._values._kept == []
    kept.close()


def test_an_instance_in_use_is_lent_once(built, tmp_path):
    kept = KeptFmus(tmp_path)
    part = system(built["resets"]).components[0]
    first = kept.start(part, read_description(part), print)
    second = kept.start(part, read_description(part), print)
    assert first is not second
    kept.end(first)
    assert kept.start(part, read_description(part), print) is first
    kept.end(first)
    kept.end(second)
    kept.close()
