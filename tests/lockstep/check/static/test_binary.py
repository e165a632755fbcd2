"""Static checks of the libraries: symbols against flags, and dependencies."""

import struct
import subprocess
import zipfile
from pathlib import Path

import pytest

from lockstep.check.static.elf import read_library
from lockstep.check.static.exported import functions_of

from ..conftest import BINARY, XML, Compile, Find, Make, bad, text_of

FUNCTIONS = functions_of("2.0", "good")


def test_required_functions_are_those_of_the_header(standard_functions: list[str]) -> None:
    assert sorted(FUNCTIONS) == sorted(standard_functions)


def test_flag_without_its_function_is_reported(make: Make, found: Find, compiled: Compile) -> None:
    findings = found(make({BINARY: compiled(without=("fmi2SetFMUstate",))}))

    assert bad(findings) == {"static.functions": "error"}
    assert "canGetAndSetFMUstate is true, but fmi2SetFMUstate is not exported" in text_of(findings["static.functions"])


def test_missing_function_without_a_flag_is_reported(make: Make, found: Find, compiled: Compile) -> None:
    findings = found(make({BINARY: compiled(without=("fmi2GetDirectionalDerivative", "fmi2CancelStep"))}))

    assert bad(findings) == {"static.functions": "error"}
    says = text_of(findings["static.functions"])
    assert "not exported: fmi2GetDirectionalDerivative, fmi2CancelStep" in says
    assert "is true" not in says


def test_hidden_function_counts_as_missing(make: Make, found: Find, compiled: Compile) -> None:
    hidden = '__attribute__((visibility("hidden"))) int fmi2Reset(void) { return 0; }'
    findings = found(make({BINARY: compiled(without=("fmi2Reset",), code=hidden)}))

    assert "fmi2Reset" in text_of(findings["static.functions"])


PYTHON = "int Py_IsInitialized(void); int ready(void) { return Py_IsInitialized(); }"
DOCUMENTED = {"documentation/externalDependencies.txt": "A Python 3.11 with numpy in the host's process."}


@pytest.mark.parametrize(
    ("files", "execution", "status"),
    [({}, "true", "warning"), (DOCUMENTED, "false", "info"), (DOCUMENTED, "true", "info")],
)
def test_need_of_python_in_the_host_must_be_documented(
    make: Make, found: Find, compiled: Compile, files: dict[str, str], execution: str, status: str
) -> None:
    xml = XML.replace("<CoSimulation ", f'<CoSimulation needsExecutionTool="{execution}" ')
    findings = found(make({BINARY: compiled(code=PYTHON), **files}, xml=xml))

    assert bad(findings) == {"static.dependencies": status}
    assert "needs libpython in the host (1 symbols" in text_of(findings["static.dependencies"])


@pytest.mark.parametrize(
    ("inner", "who"),
    [
        ("resources/plant/binaries/linux64/plant.so", "the FMU inside, resources/plant/binaries/linux64/plant.so,"),
        ("binaries/linux64/wrapper.so", "wrapper.so in the same folder"),
    ],
)
def test_inner_library_that_needs_python_is_reported(
    make: Make, found: Find, compiled: Compile, inner: str, who: str
) -> None:
    """A container needs what its parts need, and a library what it loads, without symbols that show it."""
    silent = found(make({inner: compiled(code=PYTHON)}))
    harmless = found(make({inner: compiled(), "resources/extension.so": b"no library"}))

    assert bad(silent) == {"static.dependencies": "warning"}
    assert f"{who} needs libpython" in text_of(silent["static.dependencies"])
    assert bad(harmless) == {}


def test_undefined_symbol_is_reported(make: Make, found: Find, compiled: Compile) -> None:
    code = "double solve_it(double); double f(void) { return solve_it(1.0); }"
    findings = found(make({BINARY: compiled(code=code)}))

    assert bad(findings) == {"static.dependencies": "error"}
    assert "solve_it" in text_of(findings["static.dependencies"])


def test_symbols_of_needed_libraries_are_found(make: Make, found: Find, compiled: Compile) -> None:
    code = "double cos(double); double f(double x) { return cos(x); }"
    findings = found(make({BINARY: compiled("-Wl,--no-as-needed", "-lm", code=code)}))

    assert bad(findings) == {}
    assert "libm.so.6" in text_of(findings["static.dependencies"])


def test_missing_library_is_reported_unless_it_is_in_the_fmu(make: Make, found: Find, tmp_path: Path) -> None:
    compile_ = ["gcc", "-shared", "-fPIC"]
    (tmp_path / "solver.c").write_text("double solve_it(double x) { return x; }")
    subprocess.run([*compile_, "-o", "libvendorsolver.so", "solver.c"], cwd=tmp_path, check=True)
    names = "\n".join(f"int {name}(void) {{ return 0; }}" for name in FUNCTIONS)
    (tmp_path / "good.c").write_text(f"double solve_it(double); double f(void) {{ return solve_it(1); }}\n{names}")
    link = ["-L.", "-lvendorsolver", "-Wl,-rpath,/home/vendor/lib"]
    subprocess.run([*compile_, "-o", "good.so", "good.c", *link], cwd=tmp_path, check=True)
    library = (tmp_path / "good.so").read_bytes()

    alone = found(make({BINARY: library}))
    assert bad(alone) == {"static.dependencies": "warning"}
    assert "needs libvendorsolver.so, which is neither" in text_of(alone["static.dependencies"])
    assert "/home/vendor/lib" in text_of(alone["static.dependencies"])

    solver = (tmp_path / "libvendorsolver.so").read_bytes()
    both = found(make({BINARY: library, "binaries/linux64/libvendorsolver.so": solver}))
    assert "neither" not in text_of(both["static.dependencies"])
    assert "solve_it" not in text_of(both["static.dependencies"])


def test_library_of_another_machine_is_reported(make: Make, found: Find, library: bytes) -> None:
    arm = bytearray(library)
    struct.pack_into("<H", arm, 18, 183)  # e_machine: AArch64

    findings = found(make({BINARY: bytes(arm)}))
    assert findings["static.functions"].status == "error"
    assert "EM_AARCH64, not x86-64" in text_of(findings["static.functions"])


@pytest.mark.parametrize("content", [b"", b"MZ", b"\x7fELF", b"\x7fELF\2\1\1" + b"\xff" * 200])
def test_file_that_is_not_a_library_is_reported(make: Make, found: Find, content: bytes) -> None:
    findings = found(make({BINARY: content}))

    assert findings["static.functions"].status == "error"


@pytest.mark.parametrize("cut", [70, 1000, 5000, -2000])
def test_truncated_library_is_reported(make: Make, found: Find, library: bytes, cut: int) -> None:
    assert found(make({BINARY: library[:cut]}))["static.functions"].status == "error"


@pytest.mark.parametrize(("machine", "status"), [(0x8664, "pass"), (0x014C, "warning")])
def test_windows_library_must_match_its_folder(make: Make, found: Find, machine: int, status: str) -> None:
    library = bytearray(256)
    library[:2], library[0x80:0x84] = b"MZ", b"PE\0\0"
    struct.pack_into("<I", library, 0x3C, 0x80)
    struct.pack_into("<H", library, 0x84, machine)

    assert found(make({"binaries/win64/good.dll": bytes(library)}))["static.platforms"].status == status


def test_library_for_arm_has_the_folder_of_fmi_3(make: Make, found: Find, library: bytes) -> None:
    arm = bytearray(library)
    struct.pack_into("<H", arm, 18, 183)  # e_machine: AArch64

    both = found(make({"binaries/aarch64-linux/good.so": bytes(arm)}))["static.platforms"]
    assert (both.status, both.message) == ("pass", "aarch64-linux, linux64")
    wrong = found(make({"binaries/aarch64-linux/good.so": library}))["static.platforms"]
    assert (wrong.status, "is an ELF file for machine 62" in wrong.message) == ("warning", True)


def test_symbols_agree_with_nm(tmp_path: Path, toys: Path) -> None:
    """An independent reader: nm, which comes with the linker that gcc needs."""
    with zipfile.ZipFile(toys / "toy_echo.fmu") as archive:
        library = archive.read(next(n for n in archive.namelist() if n.startswith("binaries/linux64/")))
    (tmp_path / "toy.so").write_bytes(library)
    lines = subprocess.run(["nm", "-D", tmp_path / "toy.so"], check=True, capture_output=True, text=True).stdout
    rows = [line.rsplit(maxsplit=2)[-2:] for line in lines.splitlines()]
    read = read_library(library)

    assert {name.partition("@")[0] for kind, name in rows if kind == "U"} == read.undefined
    assert {name.partition("@")[0] for kind, name in rows if kind in "TtDBRVWu" and not name.startswith("_ITM")} >= {
        name for name in read.exported if name.startswith("fmi2")
    }
