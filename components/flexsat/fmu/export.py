"""Build an FMU from a shell: the same sources and resources give the same bytes."""

from __future__ import annotations

import hashlib
import importlib
import importlib.metadata
import json
import re
import sys
import tempfile
import uuid
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pythonfmu import FmuBuilder
from pythonfmu._version import __version__ as pythonfmu_version

from ..ports.table import Naming
from .python.resources import BUILD_FILE
from .python.shim import WRAPPER, shim_library, shim_sources
from .reproducible_zip import write_atomically, zip_bytes
from .source_bundle import module_sources

_SCRIPT = """\
import ctypes; ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))  # pythonfmu drops one reference at each load
from {package}.{module} import {name}
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class BuiltFmu:
    """A built FMU: where it is, the GUID of its content, and the SHA-256 of the file."""

    path: Path
    guid: str
    sha256: str


def build_fmu(
    shell: str,
    out: Path,
    resources: Mapping[str, bytes],
    model_name: str,
    documentation: Mapping[str, bytes] | None = None,
    extra: Mapping[str, bytes] | None = None,
    naming: Naming = "structured",
    execution_tool: bool = False,
) -> BuiltFmu:
    """Build a shell into an FMU.

    Parameters
    ----------
    shell : import path of the final class, such as "flexsat.fmu.python.plant:Plant"
    out : file to write; replaced in one piece
    resources : files below resources/, found by `ComponentSlave.resource`
    model_name : a C identifier; names the model and its binaries
    documentation : files below documentation/
    extra : files at other places in the archive, such as "model.png"
    naming : of the variables; value references and results are the same in both
    execution_tool : declare that a tool is needed to execute the FMU

    Raises
    ------
    ValueError
        For a bad name, or a source that imports what an FMU does not have.
    """
    if not re.fullmatch(r"[A-Za-z_]\w*", model_name, re.ASCII):
        raise ValueError(f"model_name must be a C identifier, got {model_name!r}")
    module, colon, class_name = shell.partition(":")
    if not (colon and "." in module and class_name.isidentifier()):
        raise ValueError(f"shell must look like 'package.module:Class', got {shell!r}")
    top, inner = module.split(".", 1)
    sources = module_sources(module)
    shim = shim_sources()
    version = importlib.metadata.version("flexsat")
    content = _content_hash(
        sources, resources, shim, (shell, model_name, version, pythonfmu_version, naming, execution_tool)
    )
    guid = f"{{{uuid.uuid5(uuid.NAMESPACE_OID, content)}}}"
    package, script = f"{top}_{content[:16]}", f"{model_name}_{content[:16]}"
    facts = {
        "model_name": model_name,
        "guid": guid,
        "version": version,
        "shell": shell,
        "naming": naming,
        "needs_execution_tool": execution_tool,
        "content": content,
    }
    files = {f"{package}/{path.split('/', 1)[1]}": source for path, source in sources.items()}
    files |= resources
    files[BUILD_FILE] = (json.dumps(facts, indent=2) + "\n").encode()
    files[f"{script}.py"] = _SCRIPT.format(package=package, module=inner, name=class_name).encode()
    entries = _built(files, script, (package, script))
    library = f"binaries/linux64/{model_name}.so"
    entries[f"binaries/linux64/{WRAPPER}"] = entries.pop(library)
    entries[library] = shim_library()
    entries |= {f"documentation/{name}": page for name, page in (documentation or {}).items()}
    for name, file in (extra or {}).items():
        if name in entries:
            raise ValueError(f"extra file {name!r} would replace a part of the FMU")
        entries[name] = file
    archive = zip_bytes(entries)
    write_atomically(out, archive)
    return BuiltFmu(path=out, guid=guid, sha256=hashlib.sha256(archive).hexdigest())


def _content_hash(
    sources: Mapping[str, bytes],
    resources: Mapping[str, bytes],
    shim: Mapping[str, bytes],
    facts: tuple[str | bool, ...],
) -> str:
    digest = hashlib.sha256(json.dumps(facts).encode())
    for group in (sources, resources, shim):
        for name in sorted(group):
            for part in (name.encode(), group[name]):
                digest.update(len(part).to_bytes(8, "little") + part)
    return digest.hexdigest()


def _built(files: Mapping[str, bytes], script: str, modules: tuple[str, ...]) -> dict[str, bytes]:
    """Let pythonfmu build, and return what it put into the archive."""
    with tempfile.TemporaryDirectory(prefix="flexsat_build_") as folder, _untouched_interpreter(folder, modules):
        stage = Path(folder) / "stage"
        for name, content in files.items():
            path = stage / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        parts = [path for path in sorted(stage.iterdir()) if path.name != f"{script}.py"]
        target = Path(folder) / "built.fmu"
        FmuBuilder.build_FMU(stage / f"{script}.py", dest=target, project_files=parts)
        with zipfile.ZipFile(target) as archive:
            names = [name for name in archive.namelist() if "__pycache__" not in name and not name.endswith(".pyc")]
            return {name: archive.read(name) for name in names}


@contextmanager
def _untouched_interpreter(folder: str, modules: tuple[str, ...]) -> Iterator[None]:
    """Take back what a build leaves in the interpreter: search path, loaded modules, compiled files."""
    search_path, bytecode = list(sys.path), sys.dont_write_bytecode
    sys.dont_write_bytecode = True
    importlib.invalidate_caches()
    try:
        yield
    finally:
        sys.dont_write_bytecode = bytecode
        sys.path[:] = search_path
        for name in [name for name in sys.modules if name.partition(".")[0] in modules]:
            del sys.modules[name]
        for entry in [entry for entry in sys.path_importer_cache if "pythonfmu_" in entry or entry.startswith(folder)]:
            del sys.path_importer_cache[entry]
