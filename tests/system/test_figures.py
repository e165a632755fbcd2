"""`flexsat figures` as a user runs it: design and runs, of which configuration, and what it refuses."""

from pathlib import Path

import pytest

from flexbench.cli.figures import runs_of

SIGNATURE = {".png": b"\x89PNG", ".svg": b"<?xml"}


@pytest.fixture(scope="module")
def flown(tmp_path_factory, fmus, flexsat):
    """Return a folder of short runs: slews of both configurations, fine pointing with the loop closed and open."""
    folder = tmp_path_factory.mktemp("flown")
    for name, scenario in (
        ("centralised", "slew"),
        ("distributed", "slew"),
        ("centralised", "fine_pointing"),
        ("centralised", "fine_pointing_open_loop"),
    ):
        out = folder / f"{name}-{scenario}"
        cut = ("--accept-infeasible",) if scenario == "slew" else ()  # it ends before the slew begins
        done = flexsat(
            "run", fmus / name / f"{scenario}.ssd", "--native", "--stop-time", "1", "--seed", "4", "--out", out, *cut
        )
        assert done.returncode == 0, done.stderr
    return folder


def written(done, folder):
    """Return the names of the figures that the command printed, each there as PNG and SVG, none empty."""
    assert (done.returncode, done.stderr) == (0, "")
    paths = [Path(line) for line in done.stdout.split()]
    assert sorted(paths) == sorted(folder.iterdir())
    for path in paths:
        content = path.read_bytes()
        assert content.startswith(SIGNATURE[path.suffix])
        assert len(content) > 20_000
    names = [path.stem for path in paths if path.suffix == ".png"]
    assert names == [path.stem for path in paths if path.suffix == ".svg"]
    return names


def test_runs_are_drawn_both_configurations_together(flown, flexsat, tmp_path):
    done = flexsat("figures", flown, "--out", tmp_path / "drawn")

    assert sorted(written(done, tmp_path / "drawn")) == ["fine-pointing-seed4", "slew-seed4"]
    labels = (tmp_path / "drawn" / "slew-seed4.svg").read_text()
    assert "<!-- centralised -->" in labels
    assert "<!-- distributed -->" in labels
    assert "open loop -->" in (tmp_path / "drawn" / "fine-pointing-seed4.svg").read_text()


def test_runs_of_one_configuration_are_taken_from_a_folder(flown):
    runs = runs_of([flown, flown / "distributed-slew"], ["distributed"])

    assert [run.folder.name for run in runs] == ["distributed-slew", "distributed-slew"]
    opened = {run.folder.name for run in runs_of([flown], ["centralised"]) if run.open_loop}
    assert opened == {"centralised-fine_pointing_open_loop"}


def test_a_figure_that_lacks_a_signal_is_refused_by_name(fmus, flexsat, tmp_path):
    system, run = fmus / "centralised" / "slew.ssd", tmp_path / "run"
    words = ("--native", "--accept-infeasible", "--stop-time", "0.1", "--record", "plant.rate", "--out", run)
    done = flexsat("run", system, *words)
    assert done.returncode == 0

    done = flexsat("figures", run, "--out", tmp_path / "drawn")

    assert done.returncode == 2
    assert done.stderr.startswith("flexsat: figure slew-seed1: controller.wheel.torque: not recorded")
    assert done.stderr.count("\n") == 1


def test_the_design_is_drawn_without_results(flexsat, tmp_path):
    done = flexsat("figures", "--configuration", "centralised", "--out", tmp_path / "drawn")

    assert written(done, tmp_path / "drawn") == [
        "structure",
        "mode-shapes",
        "campbell",
        "software",
        "wheel-responses-centralised",
        "architecture-centralised",
    ]


def test_what_holds_no_run_is_refused_in_one_line(flown, flexsat, tmp_path):
    for arguments, message in (
        ([tmp_path], f"flexsat: {tmp_path}: neither a run's results folder nor one that holds such"),
        (
            [flown / "centralised-slew", "--configuration", "distributed"],
            "flexsat: --configuration distributed: none of the 1 runs is of it",
        ),
        (["--configuration", "circular"], "flexsat: --configuration: 'circular' is none of centralised, distributed"),
    ):
        done = flexsat("figures", *arguments, "--out", tmp_path / "drawn")

        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.startswith(message)
        assert done.stderr.count("\n") == 1
    assert not (tmp_path / "drawn").exists()
