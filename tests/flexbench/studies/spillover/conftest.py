"""The robust designs, and real structures of up to 60 modes."""

import pytest

from flexbench.studies.margins.real_plant import Plants
from flexsat.description.built_in import CONFIGURATIONS, configuration
from flexsat.design.chain import build_design

MOST = 60  # modes: 15 Hz, where the loops have long rolled off; all 198 are a script of tests/bench


@pytest.fixture(scope="session")
def robust():
    return {name: Plants(build_design(configuration(name, "robust")), MOST) for name in CONFIGURATIONS}


@pytest.fixture(scope="session")
def published():
    return {name: Plants(build_design(configuration(name, "published")), MOST) for name in CONFIGURATIONS}
