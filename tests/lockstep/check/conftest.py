"""A good FMU for the static checks, with a library of real symbols, and ways to spoil it."""

import re
import subprocess
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

import fmpy
import pytest

from lockstep.check.report.finding import Finding
from lockstep.check.static.fmu_archive import read_archive
from lockstep.check.static_checks import static_checks

XML = Path(__file__).with_name("good.xml").read_text(encoding="utf-8")
BINARY = "binaries/linux64/good.so"
MODEL_EXCHANGE = {
    "fmi2EnterEventMode", "fmi2NewDiscreteStates", "fmi2EnterContinuousTimeMode", "fmi2CompletedIntegratorStep",
    "fmi2SetTime", "fmi2SetContinuousStates", "fmi2GetDerivatives", "fmi2GetEventIndicators",
    "fmi2GetContinuousStates", "fmi2GetNominalsOfContinuousStates",
}  # fmt: skip

Compile = Callable[..., bytes]
Make = Callable[..., Path]
Find = Callable[[Path], dict[str, Finding]]


@pytest.fixture(scope="session")
def standard_functions() -> list[str]:
    """Return the functions of co-simulation as the standard's header declares them."""
    header = Path(fmpy.__file__).parent / "c-code" / "fmi2Functions.h"
    declared = re.findall(r"FMI2_Export\s+(fmi2\w+)TYPE", header.read_text(encoding="utf-8"))
    return [name for name in dict.fromkeys(declared) if name not in MODEL_EXCHANGE]


@pytest.fixture(scope="session")
def compiled(tmp_path_factory: pytest.TempPathFactory, standard_functions: list[str]) -> Compile:
    """Return a function that compiles a library that exports all functions but some, with code and options added."""

    def compile_library(*options: str, without: tuple[str, ...] = (), code: str = "") -> bytes:
        folder = tmp_path_factory.mktemp("library")
        text = "\n".join(f"int {name}(void) {{ return 0; }}" for name in standard_functions if name not in without)
        (folder / "good.c").write_text(f"{code}\n{text}\n")
        command = ["gcc", "-shared", "-fPIC", "-o", "good.so", "good.c", *options]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        return (folder / "good.so").read_bytes()

    return compile_library


@pytest.fixture(scope="session")
def library(compiled: Compile) -> bytes:
    """Return a library that exports all functions."""
    return compiled()


@pytest.fixture
def make(tmp_path: Path, library: bytes) -> Make:
    """Return a function that writes the good FMU with members replaced, added, or left out (None)."""

    def make_fmu(
        changes: Mapping[str, str | bytes | None] | None = None, xml: str = XML, name: str = "good.fmu"
    ) -> Path:
        members: dict[str, str | bytes | None] = {
            "modelDescription.xml": xml,
            BINARY: library,
            "documentation/index.html": "<p>What it does.</p>",
            "documentation/licenses/license.txt": "Do as you like.",
        }
        with zipfile.ZipFile(tmp_path / name, "w", zipfile.ZIP_DEFLATED) as archive:
            for member, content in (members | dict(changes or {})).items():
                if content is not None:
                    archive.writestr(member, content)
        return tmp_path / name

    return make_fmu


@pytest.fixture(scope="session")
def found() -> Find:
    """Return a function that runs the static checks and returns each finding by the check's id."""
    return lambda path: {finding.check: finding for finding in static_checks(read_archive(path))}


def bad(findings: Mapping[str, Finding]) -> dict[str, str]:
    """Return the status of what did not pass."""
    return {check: f.status for check, f in findings.items() if f.status != "pass"}


def text_of(finding: Finding) -> str:
    """Return message and details of a finding."""
    return "\n".join([finding.message, *finding.details])
