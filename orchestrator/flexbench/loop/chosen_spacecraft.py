"""Find the spacecraft that a command is about: a built-in name, a spacecraft's file, or a folder of FMUs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from flexsat.description.built_in import CONFIGURATIONS, built_in
from flexsat.description.spacecraft_file import SpacecraftFile
from flexsat.design.chain import Designs, build_designs
from flexsat.parameters import DEFAULT_DESIGN, ConfigurationName, Slew
from lockstep.errors import InputError

from .build import build_all, build_files
from .build_options import STANDARD, BuildOptions
from .spacecraft import FILE, design_file, designs_for, read_file, spacecraft_of

TOML = ".toml"


@dataclass(frozen=True, slots=True, kw_only=True)
class Chosen:
    """A spacecraft, and where its FMUs are or will be built: root/name."""

    name: ConfigurationName
    root: Path
    file: Path | None = None  # that describes it; None: it is built in, or the file lies with the FMUs

    @property
    def folder(self) -> Path:
        """The folder of its FMUs."""
        return self.root / self.name

    @property
    def description(self) -> SpacecraftFile:
        """What it is; InputError if that is not known."""
        if self.file is not None:
            return read_file(self.file)
        return spacecraft_of(self.name, self.folder / "plant.fmu")

    @property
    def modes(self) -> int:
        """Number of modes of its plant."""
        return self.description.configurations[DEFAULT_DESIGN].modes.plant

    def designs(self) -> Designs:
        """Run its design chain; InputError if there is no design."""
        if self.file is not None:
            return design_file(read_file(self.file), self.file)
        return designs_for(self.name, self.folder / "plant.fmu")


def choose(texts: Sequence[str], root: Path) -> tuple[Chosen, ...]:
    """Return the spacecraft that texts name, the built-in ones if there are none; in their usual order.

    Parameters
    ----------
    texts : names of built-in spacecraft or of folders in `root`, paths of spacecraft's files or of folders of FMUs
    root : folder of folders of FMUs

    Raises
    ------
    InputError
        For a text that names none.
    """
    found = {one.name: one for one in (_choose(text, root, "--configuration") for text in texts or CONFIGURATIONS)}
    usual = [name for name in CONFIGURATIONS if name in found]
    return tuple(found[name] for name in [*usual, *(name for name in found if name not in usual)])


def _choose(text: str, root: Path, option: str) -> Chosen:
    if text in CONFIGURATIONS:
        return Chosen(name=text, root=root)
    path = Path(text)
    if path.suffix == TOML:
        return Chosen(name=read_file(path).name, root=root, file=path)
    for folder in (path, root / text):
        if (folder / FILE).is_file():
            name = read_file(folder / FILE).name
            if name == folder.resolve().name:
                return Chosen(name=name, root=folder.parent)
        if folder.name in CONFIGURATIONS and (folder / "plant.fmu").is_file():
            return Chosen(name=folder.name, root=folder.parent)
    raise InputError(
        f"{option}: '{text}' is none of {', '.join(CONFIGURATIONS)}, a spacecraft's file such as my.toml, and a"
        " folder of FMUs such as fmus/my"
    )


def build_missing(chosen: Sequence[Chosen], scenario: str, options: BuildOptions = STANDARD) -> None:
    """Build the FMUs of spacecraft that have no system of a scenario yet.

    Raises
    ------
    InputError
        If FMUs are there of another description than the spacecraft's file now has, or they cannot be built.
    """
    missing = [one for one in chosen if not (one.folder / f"{scenario}.ssd").is_file()]
    for one in chosen:
        built = one.folder / FILE
        if one.file is not None and one not in missing and built.read_bytes() != one.file.read_bytes():
            raise InputError(f"{one.folder}: built from another {one.file}; run `flexsat build {one.file}` again")
    for root in dict.fromkeys(one.root for one in missing):
        names = tuple(one.name for one in missing if one.root == root and one.file is None)
        if names:
            build_all(names, root, options=options)
        files = [one.file for one in missing if one.root == root and one.file is not None]
        if files:
            build_files(files, root, options=options)


def slew_of(name: ConfigurationName, fmu: Path) -> Slew:
    """Return the slew that a spacecraft's file commands; that of a built-in one is the paper's."""
    read = built_in(name) if name in CONFIGURATIONS else spacecraft_of(name, fmu)
    return read.configurations[DEFAULT_DESIGN].slew


def designs_named(text: str, root: Path) -> Designs:
    """Return the designs of the spacecraft that a text names, as `choose` does."""
    if text in CONFIGURATIONS:
        return build_designs(text)
    return _choose(text, root, "--like").designs()
