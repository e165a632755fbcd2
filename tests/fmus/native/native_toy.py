"""Build the toy of counter.c as a native FMU: the ports are those of the Python toy."""

import importlib
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import flexsat
from flexsat.fmu.native.export import NativeComponent, NativeContent, native_content
from flexsat.fmu.python.model_description import about_component
from flexsat.fmu.reproducible_zip import zip_bytes
from flexsat.ports.table import FmiVersion, Port, PortTable

HERE = Path(__file__).parent
FOLLOWER = (
    Port(name="u", causality="input", size=2, start=(2.0, 3.0), description="inputs"),
    Port(name="y", causality="output", size=2, depends_on=("u",), follows_inputs=True, description="they follow"),
    Port(name="x", causality="output", description="state"),
    Port(name="n", causality="output", kind="integer", description="an integer"),
    Port(name="gain", causality="parameter", start=0.5, variability="tunable", description="gain"),
    Port(name="begin", causality="parameter", start=1.0, description="state at the start"),
)


def counter_component(main: Path = HERE / "counter.c") -> NativeComponent:
    """Return what the FMU of the toy is made from; `main` may be a changed copy."""
    flexsat.__path__.append(str(HERE.parent))
    try:
        counter = importlib.import_module("flexsat.toys.counter")
    finally:
        flexsat.__path__.remove(str(HERE.parent))
        for name in [name for name in sys.modules if name.startswith("flexsat.toys")]:
            del sys.modules[name]  # other tests change copies of the toys, and import those
    shell = counter.Counter(instance_name="toy")
    return NativeComponent(
        main=main,
        table=shell.table,
        variants={},
        about=replace(about_component(shell, {"version": "1"}, "flexsat tests"), model_name="toy"),
        equal_steps=False,
        step_parameter=None,
    )


def build_native_toy(path: Path, main: Path = HERE / "counter.c", fmi: FmiVersion = "2.0") -> NativeContent:
    """Write the FMU and return its content."""
    made = native_content(counter_component(main), fmi)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(zip_bytes(made.entries))
    return made


def build_follower(path: Path, fmi: FmiVersion = "2.0") -> None:
    """Write the FMU of the toy of follower.c, which has no Python twin: outputs that follow inputs, a tunable gain."""
    about = replace(counter_component().about, model_name="follower")
    component = replace(counter_component(), main=HERE / "follower.c", table=PortTable(FOLLOWER), about=about)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(zip_bytes(native_content(component, fmi).entries))


def changed_counter(folder: Path, *replacements: tuple[str, str]) -> Path:
    """Return a copy of the toy's source in a folder, with texts replaced."""
    text = (HERE / "counter.c").read_text(encoding="utf-8")
    for old, new in replacements:
        assert old in text, old
        text = text.replace(old, new)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "counter.c").write_text(text, encoding="utf-8")
    return folder / "counter.c"


def compiler_is_missing() -> str:
    """Return why native FMUs cannot be built here, or nothing."""
    return "" if shutil.which("cc") or shutil.which("gcc") else "no C compiler: neither `cc` nor `gcc` is on the path"
