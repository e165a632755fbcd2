"""The arrows between modules are those of the architecture, and no others; modules are short and documented."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = {"flexsat": ROOT / "components", "lockstep": ROOT / "orchestrator", "flexbench": ROOT / "orchestrator"}
LONGEST = 410  # lines

# Which packages of others a package may use, and which modules of it may: design modules, edges, one owner each.
ALLOWED = {
    "flexsat": {
        "numpy": "*",
        "scipy": "design",  # every module that does not travel in an FMU
        "control": "design",
        "clarabel": {"slew_programme"},
        "pythonfmu": {"export", "shells.base"},
        "matplotlib": {"documentation.drawing"},
    },
    "lockstep": {
        "numpy": "*",
        "fmpy": {"fmu", "fmi1", "fmi2", "fmi3", "check.experiment", "check.drive"},
        "lxml": {
            *("ssp", "ssp_xml", "ssp_writer", "ssp_package", "ssp_export", "srmd"),
            *("check.model", "check.description_checks"),
        },
        "elftools": {"check.elf"},
        "pyarrow": {"results", "recorder"},
        "rich": {"progress", "check.report_text"},
    },
    "flexbench": {
        "numpy": "*",
        "flexsat": "*",
        "lockstep": "*",
        "matplotlib": {"figures"},
        "rich": {"campaign", "table", "health", "margins.command"},
        "xarray": {"", "dataset", "export"},  # "": the package itself
        "pyarrow": {"export"},
        "scipy": {"export", "health.statistics", "margins.estimate", "spectra.welch"},
    },
}  # fmt: skip
# What travels in the FMUs: reached from the shells. numpy alone, but for the one class that pythonfmu calls.
SHELLS = ("flexsat.shells.plant", "flexsat.shells.sensors", "flexsat.shells.controller", "flexsat.shells.injector")
STEPPERS = {"plant", "plant_parameters", "jitter", "sensors", "controller", "guidance", "rotations", "discretise",
            "periods"}  # fmt: skip


def name_of(path, root):
    """Return a module's dotted name."""
    parts = list(path.relative_to(root).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {
    name_of(path, root): path for package, root in SOURCES.items() for path in sorted((root / package).rglob("*.py"))
}


def imports(tree, module, is_package):
    """Return every module that is imported anywhere in a source: inside functions and for types too."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = module.split(".") if is_package else module.split(".")[:-1]
                parents = parts[: len(parts) - (node.level - 1)]
                base = ".".join([*parents, *([node.module] if node.module else [])])
            # `from package import module` imports the module too
            found |= {base} | {f"{base}.{alias.name}" for alias in node.names if f"{base}.{alias.name}" in MODULES}
    return found


TREES = {module: ast.parse(path.read_text(encoding="utf-8")) for module, path in MODULES.items()}
IMPORTS = {module: imports(tree, module, MODULES[module].name == "__init__.py") for module, tree in TREES.items()}


def objections(module, imported):
    """Return the imports of a module that its package does not allow it."""
    package, _, inner = module.partition(".")
    refused = []
    for name in sorted(imported):
        top = name.partition(".")[0]
        if top == package or top in sys.stdlib_module_names:
            continue
        owners = ALLOWED[package].get(top, set())
        if owners == "design":
            owners = set() if module in reached(SHELLS) else "*"
        if owners != "*" and not any(inner == owner or inner.startswith(f"{owner}.") for owner in owners):
            refused.append(name)
    return refused


def reached(start):
    """Return all modules of our packages that importing these imports."""
    seen, open_ = set(), list(start)
    while open_:
        module = open_.pop()
        if module in seen or module not in MODULES:
            continue
        seen.add(module)
        open_ += [*IMPORTS[module], module.rpartition(".")[0]]
    return seen


def test_the_walk_sees_every_source():
    assert len(MODULES) > 60
    assert {"flexsat.plant", "flexsat.shells.base", "lockstep.fmu", "flexbench.cli", "flexbench.figures"} <= set(
        MODULES
    )


@pytest.mark.parametrize("module", MODULES)
def test_a_module_imports_only_what_its_package_may(module):
    assert objections(module, IMPORTS[module]) == []


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("lockstep.master", "def f():\n    import flexsat.plant"),
        ("lockstep.plan", "from fmpy import fmi2"),
        ("flexsat.plant", "from scipy.linalg import expm"),
        ("flexsat.controller", "from lockstep import simulate"),
        ("flexsat.build", "import flexbench.cli"),
        ("flexsat.shells.plant", "from pythonfmu import Fmi2Slave"),
        ("flexbench.metrics", "import matplotlib.pyplot as plt"),
        ("flexbench.metrics", "from fmpy import dump"),
        ("flexbench.runs", "if True:\n    import pandas"),
    ],
)
def test_the_walk_notices_an_arrow_that_is_not_there(module, source):
    assert objections(module, imports(ast.parse(source), module, is_package=False))


def test_relative_imports_are_resolved():
    tree = ast.parse("from .. import plant\nfrom ..interfaces.ports import Port\nfrom .base import SiSlave")
    found = imports(tree, "flexsat.shells.plant", is_package=False)

    assert found == {"flexsat", "flexsat.plant", "flexsat.interfaces.ports", "flexsat.shells.base"}


def test_what_travels_in_an_fmu_needs_numpy_alone():
    inside = reached(SHELLS)
    foreign = {
        (module, name)
        for module in inside
        for name in IMPORTS[module]
        if name.partition(".")[0] not in {"flexsat", "numpy", *sys.stdlib_module_names}
    }

    assert {f"flexsat.{name}" for name in STEPPERS} <= inside
    assert {module for module, _ in foreign} == {"flexsat.shells.base"}
    assert {name.partition(".")[0] for _, name in foreign} == {"pythonfmu"}
    assert not inside & {"flexsat.design", "flexsat.build", "flexsat.monolith", "flexsat.parameters", "flexsat.export"}


@pytest.mark.parametrize("stepper", sorted(STEPPERS))
def test_a_stepper_knows_no_port_and_no_shell(stepper):
    assert not [m for m in reached([f"flexsat.{stepper}"]) if m.startswith(("flexsat.shells", "flexsat.interfaces"))]


def test_the_interfaces_are_free_of_shells():
    found = [module for module in MODULES if module.startswith("flexsat.interfaces")]
    assert not [module for module in reached(found) if module.startswith("flexsat.shells")]


def test_the_monolith_runs_without_fmi_files_and_master():
    inside = reached(["flexsat.monolith"])
    assert not [name for module in inside for name in IMPORTS[module] if name.startswith(("fmpy", "lockstep"))]


def test_a_run_does_not_wait_for_what_draws_and_reports():
    """Matplotlib and pandas take longer to import than a short run takes."""
    source = "import sys, flexbench.cli, flexbench.commands; flexbench.cli._parser(); print(*sys.modules)"
    told = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True).stdout.split()
    assert "flexbench.runs" in told
    assert {"matplotlib", "pandas", "xarray"} & set(told) == set()


def test_no_module_imports_itself_through_others():
    def visit(module, path):
        assert module not in path, " -> ".join([*path[path.index(module) :], module])
        if module in done:
            return
        for name in sorted(at_import(module)):
            visit(name, [*path, module])
        done.add(module)

    def at_import(module):
        """Return our modules that are imported when this one is; a package's own __init__ aside."""
        tops = ast.Module(
            body=[n for n in TREES[module].body if isinstance(n, ast.Import | ast.ImportFrom)], type_ignores=[]
        )
        names = imports(tops, module, MODULES[module].name == "__init__.py")
        return {name for name in names if name in MODULES and not module.startswith(f"{name}.") and name != module}

    done = set()
    for module in MODULES:
        visit(module, [])


@pytest.mark.parametrize("module", MODULES)
def test_a_module_is_not_too_long(module):
    assert len(MODULES[module].read_text(encoding="utf-8").splitlines()) <= LONGEST


@pytest.mark.parametrize("module", MODULES)
def test_what_is_public_has_a_docstring(module):
    tree = TREES[module]
    bodies = [tree, *(n for n in tree.body if isinstance(n, ast.ClassDef) and not n.name.startswith("_"))]
    public = [
        node
        for body in bodies
        for node in body.body
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and not node.name.startswith("_")
    ]

    assert ast.get_docstring(tree), "the module itself"
    assert [node.name for node in public if not ast.get_docstring(node)] == []
