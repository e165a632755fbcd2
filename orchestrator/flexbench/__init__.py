"""Simulate, analyse and report the flexible spacecraft: scenarios, studies, figures and the command line `flexsat`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from xarray import Dataset

    from flexsat.description.configuration import Configuration

__all__ = ["build", "load"]


def build(
    spacecraft: Configuration | Path | str,
    folder: Path | str = "fmus",
    *,
    published: Configuration | None = None,
    native: bool = True,
    fmi3: bool = False,
    platforms: Sequence[str] = (),
    print_line: Callable[[str], None] | None = None,
) -> Path:
    """Build the FMUs, systems and interface document of a spacecraft; return their folder, `folder`/<name>.

    Parameters
    ----------
    spacecraft : a `flexsat.description.configuration.Configuration`, or a spacecraft's file
    published : the same spacecraft with the weights of the FMUs' design `published`; None: those of the other design
    native, fmi3, platforms : as options of `flexsat build`
    print_line : called with notes about the design, and with the path of each file written

    Raises
    ------
    lockstep.InputError
        If the spacecraft is refused, or there is no design for it.
    """
    from flexsat.description.configuration import Configuration
    from flexsat.description.file_text import file_of
    from lockstep.errors import InputError

    from .loop.build import build_files
    from .loop.build_options import BuildOptions
    from .loop.spacecraft import check_built_in_names, read_file
    from .studies.margins.design_notes import design_notes

    try:
        given = file_of(spacecraft, published) if isinstance(spacecraft, Configuration) else read_file(Path(spacecraft))
    except ValueError as error:
        raise InputError(str(error)) from None
    check_built_in_names(given, given.name)
    options = BuildOptions(in_c=(*(("2.0",) if native else ()), *(("3.0",) if fmi3 else ())), platforms=platforms)
    build_files([given], Path(folder), print_line or (lambda _: None), options, notes=design_notes)
    return Path(folder) / given.name


def load(path: Path | str, signals: Sequence[str] | None = None) -> Dataset:
    """Load the signals of a results folder as an xarray Dataset; see `flexbench.runs.dataset.load_dataset`."""
    from .runs.dataset import load_dataset  # xarray takes a second to import, so only where it is needed

    return load_dataset(path, signals)
