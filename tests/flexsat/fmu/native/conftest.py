"""The C twins of the components, compiled once for all workers; tests skip where there is no compiler."""

import pickle
import shutil
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexsat.description.built_in import CONFIGURATIONS, configuration
from flexsat.design.chain import plant_matrices
from flexsat.ports import plant as plant_ports
from flexsat.ports.table import Port
from flexsat.runtime.plant_parameters import PlantMatrices
from flexsat.spacecraft.assembly import build_spacecraft
from flexsat.spacecraft.variation import with_modes
from flexsat.variants import AS_PUBLISHED, CORRECTED
from fmus.native.matrices import compile_with_places, give_matrices
from fmus.native.native_toy import build_follower, compiler_is_missing
from fmus.native.plant_pair import PlantPair
from fmus.native.twin import compile_twin
from fmus.raw_fmu import Library
from fmus.raw_fmu3 import Library3

Make = Callable[[Path], None]
Compiled = Callable[[str, str, Sequence[Port], Mapping[str, Any]], Path]


@pytest.fixture(scope="session")
def compiled(once: Callable[[str, Callable[[Path], None]], Path]) -> Compiled:
    """Return a function that compiles a component, under a name for its matrices, and returns the library's path."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler: `cc` is not on the path")

    def library(name: str, component: str, ports: Sequence[Port], variants: Mapping[str, Any]) -> Path:
        def make(folder: Path) -> None:
            compile_twin(component, ports, variants, folder)

        return once(f"native-{name}-{component}", make) / f"{component}.so"

    return library


@pytest.fixture(scope="session")
def follower(once: Callable[[str, Make], Path]) -> Path:
    """Return the FMU of the toy whose outputs follow its inputs, for reading only."""
    if compiler_is_missing():
        pytest.skip(compiler_is_missing())

    def make(folder: Path) -> None:
        build_follower(folder / "follower.fmu")

    return once("native-follower", make) / "follower.fmu"


@pytest.fixture
def one(library: Library | Library3) -> Generator[Any, None, None]:
    """Return a new instance of the library of a test file; what was logged before is forgotten."""
    library.logged.clear()
    made = library.instantiate()
    yield made
    made.free()


@pytest.fixture(scope="session", params=CONFIGURATIONS)
def layout(request: pytest.FixtureRequest) -> str:
    """Return the name of each layout in turn."""
    return str(request.param)


@pytest.fixture(scope="session")
def plants(once: Callable[[str, Make], Path], layout: str) -> dict[str, PlantMatrices]:
    """Return the matrices of the full plant of a layout, and of its published one, without a controller's design."""

    def make(folder: Path) -> None:
        folder.mkdir()
        (folder / "plants").write_bytes(pickle.dumps(_plants(layout)))

    found: dict[str, PlantMatrices] = pickle.loads((once(f"plants-{layout}", make) / "plants").read_bytes())
    return found


def _plants(layout: str) -> dict[str, PlantMatrices]:
    speeds = np.random.default_rng(2)
    variants = {}
    for variant in (CORRECTED, AS_PUBLISHED):
        config = configuration(layout, "robust" if variant == CORRECTED else "published")
        release = config.release_for(variant)
        craft = build_spacecraft(with_modes(config, release.modes), release)
        nominal = speeds.uniform(20.0, 80.0, craft.wheel_count)
        matrices = plant_matrices(craft, nominal, config.rates.plant, release.flexible_accelerometers)
        # wheels of unequal inertia, which the layouts have not
        variants[variant.name] = replace(
            matrices, wheel_inertia=matrices.wheel_inertia * speeds.uniform(0.5, 1.0, len(nominal))
        )
    return variants


@pytest.fixture(scope="session")
def plant_library(once: Callable[[str, Make], Path], layout: str, plants: dict[str, PlantMatrices]) -> Path:
    """Return the library of the native plant of a layout."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler: `cc` is not on the path")
    ports = plant_ports.ports(plants["corrected"])

    def make(folder: Path) -> None:
        compile_with_places("plant", ports, plants, folder, ["-O0"])  # the quickest to compile

    library = once(f"native-plant-{layout}", make) / "plant.so"
    give_matrices(library, "plant", plants)
    return library


@pytest.fixture(scope="session")
def pair(plant_library: Path, plants: dict[str, PlantMatrices]) -> Callable[..., PlantPair]:
    """Return a maker of a native plant with the Python stepper beside it, with values of ports."""
    return partial(PlantPair, plant_library, plants)
