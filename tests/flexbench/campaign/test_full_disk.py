"""A campaign on a disk that is really full: one line, exit code 1, and the same bytes once there is space."""

import subprocess
from contextlib import contextmanager, suppress

import pytest

from flexbench.campaign.campaign import read_entries
from flexbench.cli.parser import main

INPUTS = """
[input.seed]
parameter = "a.seed"
distribution = "case"
"""
KEYS = 'cases = 6\nhistories = "all"'
SIZE = 3000  # kB
STEP = 44  # kB of space that is made each time


@contextmanager
def small_disk(folder):
    """Mount a disk in memory inside the block."""
    folder.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={SIZE}k", "none", folder], capture_output=True,
                             text=True, check=False)  # fmt: skip
    if mounted.returncode != 0:
        pytest.skip(f"a small disk needs the right to mount: {mounted.stderr.strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", folder], check=True)


def fill(disk, room):
    """Leave so many kB."""
    with (disk / "filler").open("wb", buffering=0) as filler:
        with suppress(OSError):
            while True:
                filler.write(bytes(4096))
        filler.truncate((disk / "filler").stat().st_size - 1024 * room)


def test_a_full_disk_ends_a_campaign_with_one_line_and_it_goes_on(campaign_file, fly, tmp_path, capsys):
    path = campaign_file(KEYS, INPUTS)
    fly(path, tmp_path / "whole")
    places, kept = set(), []
    with small_disk(tmp_path / "disk") as disk:
        out = disk / "out"
        while "report.html" not in places:  # the last file
            fill(disk, STEP)
            capsys.readouterr()
            assert main(["campaign", str(path), "--out", str(out), "--jobs", "1"]) == 1
            (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("flexsat: ")]
            assert "No space left on device" in line
            kept.append(len(read_entries(out)))
            assert len(kept) < 9
            places.add(line.split(":")[1].removeprefix(f" {out}/").partition("/")[0])
            assert not any(one.name.startswith(".") for one in out.rglob("*"))
        (disk / "filler").unlink()
        assert main(["campaign", str(path), "--out", str(out), "--jobs", "1"]) == 0

        assert (out / "results.parquet").read_bytes() == (tmp_path / "whole/results.parquet").read_bytes()
        for name in ("run.toml", "signals.parquet"):
            assert len(list(out.glob(f"runs/*/{name}"))) == 6
    assert {"runs", "report.html"} <= places, places
    assert kept == sorted(kept), "a finished run was lost"
    assert 0 <= kept[0] < 6
