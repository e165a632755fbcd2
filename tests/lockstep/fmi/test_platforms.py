"""Folders of libraries for this machine, and for one with another processor, of which FMI 2.0 knows nothing."""

import zipfile

import fmpy
import pytest

from fmus.echo_fmu import echo_fmu
from lockstep.errors import InputError
from lockstep.fmi import platforms
from lockstep.fmi.instantiate import instantiate
from lockstep.fmi.model_description import read_description
from lockstep.fmi.platforms import PLATFORM, library_folders, library_path
from lockstep.system.component import Component

SUFFIX = fmpy.sharedLibraryExtension
ON_ARM = f"binaries/aarch64-linux/m{SUFFIX}"
USUAL = f"binaries/{PLATFORM}/m{SUFFIX}"


def test_folders_on_this_machine():
    assert library_folders("1.0") == library_folders("2.0") == (PLATFORM,)
    assert library_folders("3.0") == (fmpy.platform_tuple,)
    assert library_path("m", "2.0", {ON_ARM, USUAL}.__contains__) == USUAL
    assert library_path("m", "2.0") == USUAL


def test_on_another_processor_its_tuple_comes_before_the_folder_of_x86(monkeypatch):
    monkeypatch.setattr(platforms, "_OTHERS", ("aarch64-linux",))

    assert library_folders("2.0") == ("aarch64-linux", PLATFORM)
    assert library_path("m", "2.0", {ON_ARM, USUAL}.__contains__) == ON_ARM
    assert library_path("m", "2.0", {USUAL}.__contains__) == USUAL  # where other tools write it
    assert library_path("m", "2.0") == USUAL
    assert library_path("m", "1.0", {ON_ARM}.__contains__) == USUAL


def test_an_fmu_with_a_library_for_another_processor_alone_is_read_there(tmp_path, monkeypatch):
    given, moved = echo_fmu(tmp_path), tmp_path / "moved.fmu"
    with zipfile.ZipFile(given) as source, zipfile.ZipFile(moved, "w") as target:
        for name in source.namelist():
            target.writestr(name.replace(f"binaries/{PLATFORM}/", "binaries/aarch64-linux/"), source.read(name))
    component = Component(name="echo", source=moved, period=1_000_000)

    with pytest.raises(InputError, match=f"has no binary for {PLATFORM}; it has aarch64-linux"):
        read_description(component)
    monkeypatch.setattr(platforms, "_OTHERS", ("aarch64-linux",))
    description = read_description(component)
    assert "x" in description.variables
    instance = instantiate(component, description, tmp_path / "unpacked", lambda *_: None)
    instance.close()
