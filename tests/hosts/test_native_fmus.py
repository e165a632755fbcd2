"""The native FMUs in a C program without Python, in libcosim, ecos and FMPy, against those in Python in lockstep."""

import zipfile

import numpy as np
import pytest
import test_ecos
import test_libcosim
from availability import c_host_lacks, ecos_lacks
from hosting import Bench, distance
from test_c_host import call, loop, trajectory

TICKS = 200


class NativeBench(Bench):
    """The same bench with the native FMUs; its references are runs of those in Python."""

    def fmu(self, component, configuration="distributed"):
        """Return where a native FMU is."""
        return self.folder / configuration / "native" / f"{component}.fmu"

    def package(self, scenario, configuration="distributed"):
        """Return the package of a system with the native FMUs in the place of the others."""
        made = self.work / f"native_{scenario}.ssp"
        given = super().package(scenario, configuration)
        with zipfile.ZipFile(given) as package, zipfile.ZipFile(made, "w") as native:
            for name in package.namelist():
                own = self.folder / configuration / "native" / name.rpartition("/")[2]
                native.writestr(name, own.read_bytes() if own.suffix == ".fmu" else package.read(name))
        return made


@pytest.fixture(scope="module")
def native(delivered, tmp_path_factory):
    """Return a bench of the native FMUs."""
    return NativeBench(delivered, tmp_path_factory.mktemp("native"))


def apart(reference, found):
    """Return the largest difference in a port over the largest value in that port."""
    assert reference.names == found.names
    assert np.ptp(reference.values, axis=0).any(), "nothing moves, so that nothing is compared"
    ports = {name.partition("[")[0] for name in reference.names}
    return max(distance(port, reference, found) for port in ports if reference[port].any() or found[port].any())


@pytest.mark.skipif(bool(c_host_lacks()), reason=c_host_lacks() or "available")
def test_the_native_loop_in_c_without_python_agrees_with_that_in_python(native):
    lines, names = loop(native, TICKS)
    found = trajectory(call(native, lines, environment={}), names)  # reset, saved and serialised state too, bitwise

    assert 0.0 < apart(native.reference(TICKS), found) < 1e-10
    late = native.reference(TICKS, {("plant", "sensors"): 2, ("sensors", "plant"): 0, ("sensors", "controller"): 0,
                                    ("controller", "plant"): 0})  # fmt: skip
    assert apart(late, found) > 1e-6


@pytest.mark.skipif(bool(ecos_lacks()), reason=ecos_lacks() or "available")
def test_ecos_simulates_the_native_system(native):
    found = test_ecos.run(native, "fine_pointing", TICKS)

    assert 0.0 < apart(native.reference(TICKS, test_ecos.DELAYS), found) < 1e-10


def test_libcosim_simulates_the_native_system(native):
    found = test_libcosim.run(native, TICKS)

    assert 0.0 < apart(native.reference(TICKS, test_libcosim.DELAYS), found) < 1e-10


@pytest.mark.parametrize("component", ["plant", "sensors", "controller"])
def test_simulate_fmu_agrees_bitwise_with_low_level_calls(native, component):
    period = 5_000_000 if component == "controller" else 1_000_000  # ns
    moving = native.moving(component, "distributed")
    setup = {"inputs": moving, "step": period, "steps": 100, "times": "simulate_fmu"}
    own = {"fmu": str(native.fmu(component)), "outputs": native.outputs(component)}

    expected = native.low_level(component, "distributed", **setup)
    found = native.run("run_fmpy.py", setup | own | {"way": "simulate_fmu"})

    assert np.array_equal(expected.values, found.values)
