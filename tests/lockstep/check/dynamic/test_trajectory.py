"""Trajectories are compared by bits, and a difference is described by output, step and both values."""

from pathlib import Path

import numpy as np
import pytest

from lockstep.check.dynamic.experiment import Experiment, Port
from lockstep.check.dynamic.trajectory import Trajectory, difference, relative_difference, unlike

OUTPUTS = tuple(
    Port(name=name, kind=kind, reference=i)
    for i, (name, kind) in enumerate(
        [("x", "Real"), ("y", "Real"), ("n", "Integer"), ("b", "Boolean"), ("s", "String")]
    )
)
EXPERIMENT = Experiment(
    identifier="toy", guid="", step=0.1, step_source="test", start_time=1.0, any_step=False, once_per_process=False,
    saves_state=False, serialises_state=False, categories=(), inputs=(), outputs=OUTPUTS,
)  # fmt: skip


def run(**changes: object) -> Trajectory:
    """Return a run of three steps with the last row changed."""
    rows = [([1.0, np.nan], [3, 0], [b"text"]) for _ in range(3)]
    values = {"x": 1.0, "y": np.nan, "n": 3, "b": 0, "s": b"text", **changes}
    rows[2] = ([values["x"], values["y"]], [values["n"], values["b"]], [values["s"]])
    return Trajectory.of_rows(rows, EXPERIMENT)


def test_equal_bits_are_equal_also_not_a_number() -> None:
    assert difference(run(), run(), EXPERIMENT) == ""


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("x", np.nextafter(1.0, 2.0), "x is 1.0000000000000002 instead of 1.0 after step 13"),
        ("y", 0.0, "y is 0.0 instead of nan after step 13"),
        ("n", 4, "n is 4 instead of 3 after step 13"),
        ("b", 1, "b is 1 instead of 0 after step 13"),
        ("s", b"text, longer", "s is b'text, longer' instead of b'text' after step 13"),
    ],
)
def test_difference_of_one_bit_is_described(name: str, value: object, words: str) -> None:
    assert difference(run(**{name: value}), run(), EXPERIMENT, first=10) == words


def test_the_sign_of_zero_counts() -> None:
    assert unlike(run(x=-0.0), run(x=0.0))[2].tolist() == [True, False, False, False, False]


def test_other_outputs_are_counted() -> None:
    assert difference(run(x=2.0, n=5, b=1), run(), EXPERIMENT).endswith("and 2 other outputs sooner or later")


def test_shorter_run_differs() -> None:
    assert difference(run()[:2], run(), EXPERIMENT) == "2 steps instead of 3"


def test_relative_difference_is_scaled_by_the_output() -> None:
    assert relative_difference(run(x=1.0 + 1e-9), run()) == pytest.approx(1e-9, rel=1e-6)  # rounding of 1 + 1e-9
    assert relative_difference(run(), run()) == 0.0
    assert relative_difference(run(y=1.0), run()) == np.inf


def test_saved_trajectory_has_the_same_bits(tmp_path: Path) -> None:
    run(x=0.1).save(tmp_path / "run.npz")

    assert difference(Trajectory.load(tmp_path / "run.npz"), run(x=0.1), EXPERIMENT) == ""


def test_accumulated_times_differ_in_their_last_digits_only() -> None:
    computed = [EXPERIMENT.time(k) for k in range(200)]
    for how in ("accumulated", "subtracted"):
        times = EXPERIMENT.times(how, 200)
        assert len(times) == 200
        assert times != [(time, 0.1) for time in computed], how
        ulps = 200 * np.spacing(21.0)  # one for each addition
        assert np.abs(np.array(times)[:, 0] - computed).max() <= ulps
        assert np.abs(np.array(times)[:, 1] - 0.1).max() <= np.spacing(21.0)


def test_stimulus_stays_within_the_range() -> None:
    ports = (
        Port(name="free", kind="Real", reference=0, start=2.0, nudge=2e-3, swings=True),
        Port(name="edge", kind="Real", reference=1, start=1.0, maximum=1.0, nudge=0.1, swings=True),
        Port(name="still", kind="Real", reference=2, start=5.0, nudge=0.1),
        Port(name="flag", kind="Boolean", reference=0, start=1.0, nudge=1.0),
    )
    made = Experiment.from_json({**EXPERIMENT.as_json(), "inputs": [vars_of(port) for port in ports]})

    values = made.stimulus("Real")

    assert np.abs(values[:, 0] - 2.0).max() == pytest.approx(2e-3, rel=0.01)  # 37 samples miss the peak by 0.4 %
    assert values[:, 1].max() == 1.0
    assert values[:, 1].min() < 0.91
    assert set(values[:, 2]) == {5.0}
    assert set(made.stimulus("Boolean")[:, 0]) == {1}
    assert not np.array_equal(values[:, 0], made.stimulus("Real", phase=11)[:, 0])


def vars_of(port: Port) -> dict[str, object]:
    """Return a port as JSON has it."""
    return {name: getattr(port, name) for name in Port.__slots__}
