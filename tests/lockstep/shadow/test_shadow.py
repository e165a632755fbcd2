"""Shadows in whole runs of toy FMUs, each in a new process: recording, switchover, failures, bad options."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lockstep import Component, Connection, System, read_signals, write_ssd
from lockstep.__main__ import main
from lockstep.fmi.model_description import Variable
from lockstep.shadow.blend import remaining
from lockstep.shadow.ports import Joined, Match
from lockstep.shadow.values import OutputValues
from lockstep.system.component import Shadow

MS = 1_000_000
SLOWER = """\
step = 0.002
ignore = ["began"]
""" + "".join(f'[[output]]\nport = "{name}"\nvariable = "{name}"\n' for name in ("count", "even", "steps"))  # fmt: skip


def events(folder):
    return [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]


def test_without_a_switchover_the_run_is_the_same_bitwise(loop_ssd, toys, tmp_path, cli):
    shadow = ("--shadow", f"counter={toys / 'toy_counter.fmu'}", "--set", "counter.shadow.gain=3")
    assert cli("run", loop_ssd, "--out", tmp_path / "alone").returncode == 0
    done = cli("run", loop_ssd, "--out", tmp_path / "shadowed", *shadow)
    assert done.returncode == 0, done.stderr
    alone, shadowed = read_signals(tmp_path / "alone"), read_signals(tmp_path / "shadowed")

    for name, values in alone.columns.items():
        np.testing.assert_array_equal(shadowed[name], values, err_msg=name)
    steps = np.arange(1, 12)  # with the row at the stop time
    np.testing.assert_array_equal(shadowed["counter.original.count"], steps)
    np.testing.assert_array_equal(shadowed["counter.shadow.count"], 3 * steps)
    np.testing.assert_array_equal(shadowed["counter.residual.count"], 2 * steps)
    np.testing.assert_array_equal(shadowed["counter.shadow.began"], (steps - 1) / 1000)  # shown, though it does not act
    assert "counter_shadow minus counter, count, to 0.01 s: residual RMS 12.41, at most 12.41 in count" in done.stdout
    recorded = tomllib.loads((tmp_path / "shadowed" / "run.toml").read_text())["component"][0]
    assert recorded["period"] == 0.001
    assert recorded["parameters"] == {"shadow.gain": 3.0}
    assert recorded["shadow"]["source"] == str(toys / "toy_counter.fmu")
    assert recorded["shadow"]["outputs"] == ["count", "even", "steps"]
    assert "switchover" not in recorded["shadow"]


def test_shadow_acts_at_its_own_rate_without_a_jump(loop_ssd, toys, tmp_path, cli):
    adapter = tmp_path / "slower.toml"
    adapter.write_text(SLOWER)
    done = cli(
        "run", loop_ssd, "--out", tmp_path / "out", "--shadow", f"counter={toys / 'toy_counter.fmu'}",
        "--shadow-adapter", adapter, "--set", "counter.shadow.gain=3", "--switchover", "0.004", "--blend", "0.005",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    run = read_signals(tmp_path / "out")
    tick = np.arange(11)
    original, shadow = tick + 1.0, 3.0 * (tick // 2 + 1)
    mean, weight = 0.0, 2 * 0.001 / 0.005
    for k in range(4):  # of the differences until then, the first of them equally
        mean += max(weight, 1 / (k + 1)) * (original[k] - shadow[k] - mean)
    x = np.clip((tick - 4) / 5, 0, 1)  # ten steps are more than the blend: both parts decay together
    expected = np.where(tick < 4, original, shadow + (1 - 10 * x**3 + 15 * x**4 - 6 * x**5) * (5.0 - 9.0))

    np.testing.assert_array_equal(run["counter.original.count"], original)
    np.testing.assert_array_equal(run["counter.shadow.count"], shadow)
    np.testing.assert_array_equal(run["counter.residual.count"], shadow - original)
    np.testing.assert_allclose(run["counter.count"], expected, rtol=1e-14)  # a polynomial, rounded otherwise
    assert run["counter.count"][4] == 5.0
    assert run["counter.count"][9:].tolist() == shadow[9:].tolist()
    # other types than Real switch at once
    np.testing.assert_array_equal(run["counter.steps"], np.where(tick < 4, tick + 1, tick // 2 + 1))
    np.testing.assert_array_equal(run["counter.even"], np.where(tick < 4, tick % 2, tick // 2 % 2))
    acting = run["counter.count"]
    np.testing.assert_array_equal(run["echo.y"][:, 0], [1.0] * 5 + [acting[5]] * 5 + [acting[10]])  # its consumer
    (event,) = [event for event in events(tmp_path / "out") if event["event"] == "switchover"]
    assert (event["time"], event["to"], event["outputs"], event["offset"]) == (
        0.004,
        "counter_shadow",
        ["count"],
        [-4.0],
    )
    assert event["mean_offset"] == pytest.approx([mean], rel=1e-14)
    assert "switchover at 0.004 s: jump 0, without blending 4; step to it 1" in " ".join(done.stdout.split())


def test_noise_of_the_last_sample_decays_soon_and_a_lasting_difference_slowly():
    name, ms = "y", MS
    plan = Shadow(
        component=Component(name="shadow", source=Path("x.fmu"), period=2 * ms, kind="sampled"), period=ms,
        outputs=(name,), switchover=400 * ms, blend=200 * ms,
    )  # fmt: skip
    port = Variable(name=name, reference=0, type="Real", causality="output")
    joined = Joined(name="shadow", variables={name: port}, given=(), acting=(Match(shown=port, shadow=port),), seen=(),
                    applied=(), applied_valid=None)  # fmt: skip
    values, acting = OutputValues("Real", joined, plan), []
    for k in range(700):
        values.original[:] = 1.0 + (0.5 if k == 400 else 0.0)  # with a spike at the switchover
        values.raw[:] = 3.0
        values.pulled()
        if k == 400:
            values.keep_offset()
        values.decide(k * ms)
        acting.append(values.acting[0])
    acting = np.array(acting)

    assert np.all(acting[:400] == 1.0)
    assert acting[400] == 1.5
    assert values.mean[0] == pytest.approx(-2.0)
    np.testing.assert_allclose(acting[420:600], 3.0 - 2.0 * np.array([remaining(k, 200) for k in range(20, 200)]))
    assert 1.0 < acting[410] < 1.3  # half of the spike
    assert np.all(acting[600:] == 3.0)
    assert np.max(np.abs(np.diff(acting[400:]))) < 0.05


def test_remaining_share_is_smooth():
    shares = np.array([remaining(k, 1000) for k in range(1001)])
    assert (shares[0], shares[500], shares[1000]) == (1.0, 0.5, 0.0)
    assert np.all(np.diff(shares) < 0.0)
    assert np.max(np.abs(np.diff(shares, 2))) < 6e-6  # curvature at most 5.8 over the blend; an edge would be 1e-3
    assert abs(shares[1] - 1.0) < 1e-8  # 10 x^3
    assert remaining(5, 0) == 0.0


@pytest.fixture
def tracking(toys, tmp_path):
    """Return a system file in which a tracker follows a counter."""
    parts = {"counter": "toy_counter", "tracker": "toy_tracker", "echo": "toy_echo"}
    starts = {
        "tracker": {"applied.y": 0.0, "applied.valid": False},
        "echo": {"u[2]": 0.0, "flag": False, "number": 0},
    }
    system = System(
        name="tracking",
        tick=MS,
        stop_time=10 * MS,
        components=tuple(
            Component(
                name=name,
                source=toys / f"{fmu}.fmu",
                period=MS,
                kind="sampled",
                parameters=starts.get(name, {}),
                isolated=False,
            )
            for name, fmu in parts.items()
        ),
        connections=(
            Connection(from_component="counter", output="count", to_component="tracker", input="u"),
            Connection(from_component="tracker", output="y", to_component="echo", input="u[1]", delay=1),
        ),
    )
    write_ssd(system, tmp_path / "tracking.ssd")
    return tmp_path / "tracking.ssd"


@pytest.mark.parametrize("isolated", [False, True], ids=["shared", "isolated"])
def test_shadow_gets_the_value_that_acted_in_its_last_step(tracking, toys, tmp_path, cli, isolated):
    done = cli(
        "run", tracking, "--out", tmp_path / "out", "--shadow", f"tracker={toys / 'toy_tracker.fmu'}",
        "--set", "tracker.shadow.gain=3", "--switchover", "0.005", "--blend", "0",
        "--isolate" if isolated else "--share-process", "tracker_shadow",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    run = read_signals(tmp_path / "out")
    count = np.arange(1.0, 12.0)
    acting = np.where(run.time < 0.005, count, 3.0 * count)

    np.testing.assert_array_equal(run["tracker.y"], acting)
    np.testing.assert_array_equal(run["tracker.shadow.y"], 3.0 * count)
    np.testing.assert_array_equal(run["tracker.shadow.applied_seen"], [0.0, *acting[:-1]])
    assert np.all(run["tracker.shadow.valid_seen"] == 1.0)
    assert not np.any(run["tracker.valid_seen"])  # the original gets its connected inputs
    np.testing.assert_array_equal(run["echo.y"][:, 0], [0.0, *acting[:-1]])  # the delay of the connection stays
    components = tomllib.loads((tmp_path / "out" / "run.toml").read_text())["component"]
    assert next(c for c in components if c["name"] == "tracker")["shadow"]["isolated"] is isolated


def test_slower_shadow_gets_the_mean_of_what_acted(tracking, toys, tmp_path, cli):
    adapter = tmp_path / "slower.toml"
    ports = {"input": ("u", "applied.y", "applied.valid"), "output": ("y", "applied_seen", "valid_seen")}
    adapter.write_text(
        "step = 0.002\n"
        + "".join(
            f'[[{kind}]]\nport = "{name}"\nvariable = "{name}"\n' for kind, names in ports.items() for name in names
        )
    )
    done = cli(
        "run", tracking, "--out", tmp_path / "out", "--shadow", f"tracker={toys / 'toy_tracker.fmu'}",
        "--shadow-adapter", adapter,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    applied = read_signals(tmp_path / "out")["tracker.shadow.applied_seen"]
    np.testing.assert_array_equal(applied, [*np.repeat([0.0, 1.5, 3.5, 5.5, 7.5], 2), 9.5])


def test_after_the_switchover_the_original_may_fail(loop_ssd, toys, tmp_path, cli):
    given = ("--shadow", f"counter={toys / 'toy_counter.fmu'}", "--switchover", "0.004", "--blend", "0.002")
    failing = ("--set", "counter.fail_at=7", "--set", "counter.shadow.fail_at=-1")
    assert cli("run", loop_ssd, "--out", tmp_path / "usual", *given).returncode == 0
    usual = read_signals(tmp_path / "usual")
    for process in ("--isolate", "--share-process"):
        done = cli("run", loop_ssd, "--out", tmp_path / process, *given, *failing, process, "counter")
        assert done.returncode == 0, done.stderr
        run = read_signals(tmp_path / process)

        for name in ("counter.count", "counter.shadow.count", "plant.x", "echo.y"):
            np.testing.assert_array_equal(run[name], usual[name], err_msg=name)
        np.testing.assert_array_equal(run["counter.original.count"], np.minimum(np.arange(11) + 1, 6))  # its last
        (event,) = [event for event in events(tmp_path / process) if event["event"] == "original-lost"]
        assert event["time"] == 0.006
        assert "DoStep returned fmi2" in event["reason"]


@pytest.mark.parametrize(
    ("given", "process", "message"),
    [
        (("fail_at=3", "shadow.fail_at=-1"), ("--isolate", "counter"), "counter: fmi2DoStep returned fmi2"),
        (("shadow.fail_at=3",), ("--isolate", "counter_shadow"), "counter_shadow: fmi2DoStep returned fmi2"),
        (("shadow.fail_at=3",), ("--share-process", "counter_shadow"), "counter_shadow: fmi2DoStep returned fmi2"),
        (("shadow.nan_at=3",), (), "residual.count, shadow.count: is nan"),
    ],
    ids=["original", "isolated", "shared", "nan"],
)
def test_failure_before_the_switchover_ends_the_run_by_name(loop_ssd, toys, tmp_path, cli, given, process, message):
    shadow = ("--shadow", f"counter={toys / 'toy_counter.fmu'}", "--switchover", "0.006")
    settings = [word for text in given for word in ("--set", f"counter.{text}")]
    done = cli("run", loop_ssd, "--out", tmp_path / "out", *shadow, *settings, *process)
    assert done.returncode == 1
    assert message in done.stderr
    assert " at 0.002 s" in done.stderr
    assert done.stderr.count("\n") == 1
    assert len(read_signals(tmp_path / "out").time) == 2  # what was simulated stays readable


def test_bad_options_are_refused_in_one_line(loop, loop_ssd, toys, tmp_path, capsys):
    counter, echo = toys / "toy_counter.fmu", toys / "toy_echo.fmu"
    adapter = tmp_path / "slower.toml"
    adapter.write_text(SLOWER)

    def refused(*given, system=loop_ssd):
        out = tmp_path / "none"
        assert main(["run", *map(str, (system, "--out", out, *given))]) == 2
        assert not out.exists()
        printed = capsys.readouterr().err
        assert printed.count("\n") == 1
        return printed

    shadow = ("--shadow", f"counter={counter}")
    assert "--switchover 1: needs --shadow COMPONENT=FMU as well" in refused("--switchover", 1)
    assert "--blend 1: needs --switchover SECONDS" in refused(*shadow, "--blend", 1)
    assert "--shadow x: write COMPONENT=FMU" in refused("--shadow", "x")
    assert "countr: no such component; there are counter, echo, plant; did you mean counter?" in refused(
        "--shadow", f"countr={counter}"
    )
    assert "switchover 0.01 s: the run ends at 0.01 s; choose an earlier time" in refused(
        *shadow, "--switchover", "0.01"
    )
    assert "switchover 0.0015 s is no step of counter and its shadow, whose periods are 0.001 s and 0.001 s; choose 0.001 s or 0.002 s" in refused(*shadow, "--switchover", "0.0015")  # fmt: skip  # noqa: E501
    assert "choose 0.002 s or 0.004 s" in refused(*shadow, "--shadow-adapter", adapter, "--switchover", "0.003")
    assert "switchover -1 s must be >= 0 s" in refused(*shadow, "--switchover", "-1")
    assert "blend -1 s must be >= 0 s; 0 switches at once" in refused(*shadow, "--switchover", "0.002", "--blend", "-1")
    assert "counter_shadow.count: no such output; counter_shadow has" in refused("--shadow", f"counter={echo}")
    assert "echo: nothing reads its outputs" in refused("--shadow", f"echo={echo}")
    assert "plant: is continuous; a shadow and the component that it may replace must be sampled" in refused(
        "--shadow", f"plant={toys / 'toy_integrator.fmu'}"
    )
    assert "counter.shadow.gian: no such parameter" in refused(*shadow, "--set", "counter.shadow.gian=1")
    taken = replace(loop, components=(*loop.components, replace(loop.components[0], name="counter_shadow")))
    write_ssd(taken, tmp_path / "taken.ssd")
    assert "counter_shadow: is a component of the system" in refused(*shadow, system=tmp_path / "taken.ssd")
