"""The arrows between modules and folders are those of the tables, and no others; files are short and documented.

Every import counts: at the top, inside functions, under TYPE_CHECKING, and as text in `import_module`.
"""

import ast
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = {"flexsat": ROOT / "components", "lockstep": ROOT / "orchestrator", "flexbench": ROOT / "orchestrator"}
LONGEST = 400  # lines of any file, without exceptions
MOST_IN_A_FOLDER = 22  # files of one subject

# The folders of each package, highest first: a folder imports from those below it in the list, never from above.
# A name with a slash is a folder of its own inside the one before the slash. A top-level module is its own folder.
FOLDERS = {
    "flexsat": (
        *("closed_loop", "fmu", "fmu/embedded", "fmu/native", "fmu/python", "fmu/python/shim", "fmu/documentation"),
        *("design", "spacecraft", "description", "ports", "runtime/missions", "runtime/turning"),
        *("runtime", "structure", "variants", "parameters", "controller_weights"),
        *("slow_errors", "sensor_errors"),
        *("quantities", "allocation", "fixed_order", "double_double", "arrays", "errors"),
    ),
    "lockstep": (
        *("__main__", "cli", "check", "check/latency", "check/dynamic", "check/static", "check/report", "simulation"),
        *("bundle", "checkpoint", "run", "ssp", "ssp/documents", "faults", "tick", "plan", "shadow", "adapter"),
        *("results",),
        *("processes", "fmi", "system", "interrupt", "operating_system", "standard_streams", "data_text"),
        *("plain_values", "plain_table", "errors", "arrays", "array_names", "whole_file", "version"),
    ),
    "flexbench": (
        *("cli", "cli/campaign", "cli/spacecraft", "cli/options"),
        *("report", "report/campaigns", "report/sections", "figures", "adapt"),
        *("studies",),
        *("studies/layouts", "studies/paper", "studies/spillover"),
        *("studies/margins", "studies/health", "studies/robustness", "studies/shadow", "studies/waterfall"),
        *("campaign/rare", "campaign", "campaign/statistics"),
        *("studies/spectra", "studies/budget", "engine", "runs", "loop"),
        *("icd", "html"),
    ),
}  # fmt: skip

# Packages of others, and the folders or modules that may use them: design time, or one owner each.
ALLOWED = {
    "flexsat": {
        "numpy": "*",
        "scipy": {"design", "structure", "spacecraft", "fmu.documentation"},
        "control": {"design"},
        "clarabel": {"design.slew_programme"},
        "pythonfmu": {"fmu.export", "fmu.python.life_cycle"},
        "pyNastran": {"structure.nastran_extract"},  # a script for another Python, never imported
        "matplotlib": {"fmu.documentation.drawing"},
        "jinja2": {"fmu.documentation"},
    },
    "lockstep": {
        "numpy": "*",
        "scipy": {"adapter"},
        "fmpy": {"fmi"},
        "lxml": {"ssp", "check.static", "cli", "fmi.description_corrections"},
        "elftools": {"check.static.elf"},
        "pyarrow": {"results"},
        "psutil": {"processes", "operating_system", "check.dynamic.probes_load"},
        "filelock": {"operating_system"},
        "rich": {"cli", "check.report.report_text"},
        "click": {"cli"},
        "jinja2": {"check.report"},
    },
    "flexbench": {
        "numpy": "*",
        "flexsat": "*",
        "lockstep": "*",
        "matplotlib": {"figures"},
        "rich": {"cli", "studies", "engine.job_progress", "campaign"},
        "click": {"cli"},
        "jinja2": {"html", "report", "icd"},
        "xarray": {"", "runs"},  # "": the package itself
        "pyarrow": {"runs.export", "campaign"},
        "scipy": {"runs.export", "studies", "campaign", "report.motion_data"},
        "PIL": {"report.figure_images"},
        "distributed": {"engine.pools"},
    },
}  # fmt: skip
# What travels in the FMUs: reached from the shells. numpy alone, but for the one class that pythonfmu calls.
SHELLS = tuple(
    f"flexsat.fmu.python.{name}"
    for name in ("plant", "sensors", "controller", "environment", "thrusters", "mission", "test_signal_injector")
)


def name_of(path, root):
    """Return a module's dotted name."""
    parts = list(path.relative_to(root).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {
    name_of(path, root): path for package, root in SOURCES.items() for path in sorted((root / package).rglob("*.py"))
}


def imports(tree, module, is_package):
    """Return every module that is imported anywhere in a source: in functions, for types, and by `import_module`."""
    found, nodes = set(), list(ast.walk(tree))
    for node in nodes:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = module.split(".") if is_package else module.split(".")[:-1]
                parents = parts[: len(parts) - (node.level - 1)]
                base = ".".join([*parents, *([node.module] if node.module else [])])
            # `from package import module` imports the module, not what else is in the package
            inner = {f"{base}.{alias.name}" for alias in node.names} & MODULES.keys()
            found |= inner if len(inner) == len(node.names) else inner | {base}
    return found | imports_by_name(nodes, module)


def imports_by_name(nodes, module):
    """Return the modules that texts in a source name, if it calls `import_module`."""
    names = {node.id for node in nodes if isinstance(node, ast.Name)}
    if "import_module" not in names | {node.attr for node in nodes if isinstance(node, ast.Attribute)}:
        return set()
    texts = {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    parts = {text.partition(":")[0] for text in texts if re.fullmatch(r"[\w.]+(:\w+)?", text)} - {"__main__"}
    package = module.partition(".")[0]
    # a name may be whole, or stand behind the package or the folder that the source adds to it
    return {name for part in parts for name in (part, f"{package}.{part}", f"{module.rpartition('.')[0]}.{part}")
            if name in MODULES and name != module}  # fmt: skip


@cache  # read by the first test that needs them, not by each worker that collects this file
def trees():
    """Return the parsed source of each module."""
    return {module: ast.parse(path.read_text(encoding="utf-8")) for module, path in MODULES.items()}


@cache
def import_table():
    """Return the imports of each module."""
    return {module: imports(tree, module, MODULES[module].name == "__init__.py") for module, tree in trees().items()}


def folder_of(module):
    """Return the folder of a module, as FOLDERS names it: the deepest one listed, None for a package itself."""
    package, _, inner = module.partition(".")
    parts = inner.split(".") if inner else []
    for depth in range(len(parts), 0, -1):
        if "/".join(parts[:depth]) in FOLDERS[package]:
            return "/".join(parts[:depth])
    return None if not parts else "/".join(parts)


def objections(module, imported):
    """Return the imports of a module that the tables do not allow it."""
    package, _, inner = module.partition(".")
    refused = []
    for name in sorted(imported):
        top = name.partition(".")[0]
        if top in sys.stdlib_module_names:
            continue
        if top == package:
            if not runs_down(module, name):
                refused.append(name)
            continue
        owners = ALLOWED[package].get(top, set())
        if owners != "*" and not any(inner == owner or inner.startswith(f"{owner}.") for owner in owners):
            refused.append(name)
    return refused


def runs_down(module, imported):
    """Return whether the arrow stays in a folder or runs down the list. A package's face looks down on all of it."""
    order = FOLDERS[module.partition(".")[0]]
    here, there = folder_of(module), folder_of(imported)
    if here is None or there is None or here == there or imported == module.rpartition(".")[0]:
        return here is None or here == there or there is not None
    if here not in order or there not in order:
        return False
    return order.index(here) < order.index(there)


def reached(start):
    """Return all modules of our packages that importing these imports."""
    seen, open_ = set(), list(start)
    while open_:
        module = open_.pop()
        if module in seen or module not in MODULES:
            continue
        seen.add(module)
        open_ += [*import_table()[module], module.rpartition(".")[0]]
    return seen


def test_every_arrow_is_in_the_tables():
    assert len(MODULES) > 250
    refused = {f"{module} -> {name}" for module in MODULES for name in objections(module, import_table()[module])}

    assert sorted(refused) == []


def test_every_folder_is_in_the_tables():
    listed = {f"{package}.{folder.replace('/', '.')}" for package, folders in FOLDERS.items() for folder in folders}
    folders = {module for module, path in MODULES.items() if path.name == "__init__.py" and "." in module}
    modules = {module for module in MODULES if module.count(".") == 1 and module not in folders}

    assert folders | modules == listed


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("lockstep.simulation", "def f():\n    import flexsat.runtime.plant"),
        ("lockstep.plan.plan", "from fmpy import fmi2"),
        ("lockstep.plan.plan", "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import lockstep.run.exchange"),
        ("lockstep.plan.plan", "from importlib import import_module\nimport_module('lockstep.run.exchange')"),
        ("lockstep.plan.plan", "from importlib import import_module\nimport_module(f'lockstep.{x}')\ny = 'simulation'"),
        ("lockstep.fmi.slave", "def f():\n    from lockstep.processes import worker"),
        ("flexsat.runtime.plant", "from scipy.linalg import expm"),
        ("flexsat.runtime.plant", "from ..ports import plant"),
        ("flexsat.runtime.controller", "from lockstep import simulate"),
        ("flexsat.fmu.build", "import flexbench.cli"),
        ("flexsat.fmu.python.plant", "from pythonfmu import Fmi2Slave"),
        ("flexbench.runs.metrics", "import matplotlib.pyplot as plt"),
        ("flexbench.runs.metrics", "from fmpy import dump"),
        ("flexbench.runs.run_folder", "if True:\n    import pandas"),
        ("flexbench.studies.budget.evaluate", "from flexbench.figures import budget"),
    ],
)
def test_the_walk_notices_an_arrow_that_is_not_there(module, source):
    assert objections(module, imports(ast.parse(source), module, is_package=False))


def test_relative_imports_are_resolved():
    tree = ast.parse(
        "from ...runtime import plant\nfrom ...ports.table import Port\nfrom .life_cycle import PhaseError"
    )
    found = imports(tree, "flexsat.fmu.python.plant", is_package=False)

    assert found == {"flexsat.runtime.plant", "flexsat.ports.table", "flexsat.fmu.python.life_cycle"}


def test_what_travels_in_an_fmu_needs_numpy_alone():
    inside = reached(SHELLS)
    foreign = {
        (module, name)
        for module in inside
        for name in import_table()[module]
        if name.partition(".")[0] not in {"flexsat", "numpy", *sys.stdlib_module_names}
    }

    assert {"flexsat.runtime.plant", "flexsat.runtime.sensors", "flexsat.runtime.controller"} <= inside
    assert {module for module, _ in foreign} == {"flexsat.fmu.python.life_cycle"}
    assert {name.partition(".")[0] for _, name in foreign} == {"pythonfmu"}
    allowed = {
        None, "runtime", "runtime/missions", "runtime/turning", "ports", "fmu", "fmu/python", "parameters",
        "quantities", "allocation", "slow_errors", "sensor_errors", "fixed_order", "arrays", "controller_weights",
        "variants",
    }  # fmt: skip
    assert {folder_of(module) for module in inside} <= allowed


def test_the_closed_loop_runs_without_fmi_files_and_master():
    inside = reached(["flexsat.closed_loop"])
    assert not [name for module in inside for name in import_table()[module] if name.startswith(("fmpy", "lockstep"))]


def test_a_run_does_not_wait_for_what_draws_and_reports():
    """Matplotlib, pandas and the parts of SciPy, which a design needs, take longer to import than a short run takes."""
    source = (
        "import sys; from flexbench.cli.parser import main; main(['run', 'none.ssd'])\n"
        "from flexsat.description.built_in import CONFIGURATIONS, built_in\n"
        "for name in CONFIGURATIONS: built_in(name)  # its wheels are those that a run watches\n"
        "print(*sys.modules)"
    )
    loaded = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True).stdout.split()
    assert "flexbench.runs.run_folder" in loaded
    assert {"matplotlib", "pandas", "xarray"} & set(loaded) == set()
    assert {"scipy.linalg", "scipy.sparse", "scipy.spatial", "scipy.ndimage", "control"} & set(loaded) == set()


def circles(arrows):
    """Return a circle of arrows, as the names along it, or nothing."""
    done, circle = set(), []

    def visit(node, path):
        if node in path:
            circle[:] = [*path[path.index(node) :], node]
        elif node not in done and not circle:
            for name in sorted(arrows.get(node, ())):
                visit(name, [*path, node])
            done.add(node)

    for node in sorted(arrows):
        visit(node, [])
    return circle


def test_no_module_imports_itself_through_others():
    """A package's own __init__ aside, which re-exports what is in it."""
    arrows = {
        module: {name for name in import_table()[module] if name in MODULES and not module.startswith(f"{name}.")}
        - {module}
        for module in MODULES
    }

    assert circles(arrows) == []
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a"}}) == ["a", "b", "c", "a"]


def test_the_bench_refuses_bad_input_by_input_error():
    """A ValueError of a library is a bug of flexsat: exit code 70. What a user can mend is an InputError."""
    raised = {
        f"{module}:{node.lineno}"
        for module, tree in trees().items()
        if module.startswith("flexbench")
        for node in ast.walk(tree)
        if isinstance(node, ast.Raise) and node.exc is not None and "ValueError" in ast.unparse(node.exc).split("(")[0]
    }

    assert raised == set()


def test_no_file_is_too_long():
    roots = [ROOT / name for name in ("components", "orchestrator", "tests", "examples")]
    files = [path for root in roots for kind in ("py", "c", "h", "js") for path in root.rglob(f"*.{kind}")]
    lengths = {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8").count("\n") for path in files}

    assert len(lengths) > 400
    assert {name: length for name, length in lengths.items() if length > LONGEST} == {}


def test_no_folder_is_crowded():
    counts = {}
    for path in MODULES.values():
        counts[path.parent] = counts.get(path.parent, 0) + (path.name != "__init__.py")

    assert {str(folder): count for folder, count in counts.items() if count > MOST_IN_A_FOLDER} == {}


def test_what_is_public_has_a_docstring():
    lacking = []
    for module, tree in trees().items():
        bodies = [tree, *(n for n in tree.body if isinstance(n, ast.ClassDef) and not n.name.startswith("_"))]
        public = [
            node
            for body in bodies
            for node in body.body
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and not node.name.startswith("_")
        ]
        lacking += [f"{module}.{node.name}" for node in public if not ast.get_docstring(node)]
        lacking += [] if ast.get_docstring(tree) else [module]

    assert lacking == []
