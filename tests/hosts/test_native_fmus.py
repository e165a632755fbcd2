"""The native FMUs in a C program without Python, in libcosim, ecos and FMPy, against those in Python in lockstep."""

import numpy as np
import pytest
import test_ecos
import test_libcosim
from availability import c_host_lacks, ecos_lacks
from hosting import NativeBench, Row, distance
from test_c_host import call, loop, trajectory

TICKS = 200


def apart(reference, found):
    """Return the largest difference in a port over the largest value in that port."""
    assert reference.names == found.names
    assert np.ptp(reference.values, axis=0).any(), "nothing moves, so that nothing is compared"
    ports = {name.partition("[")[0] for name in reference.names}
    return max(distance(port, reference, found) for port in ports if reference[port].any() or found[port].any())


def in_c(native):
    """Return the loop in a C program; reset, saved and serialised state repeat it bitwise, or it fails."""
    lines, names = loop(native, TICKS)
    return trajectory(call(native, lines, environment={}), names)


def in_ecos(native):
    """Return the loop in ecos."""
    return test_ecos.run(native, "fine_pointing", TICKS)


def in_libcosim(native):
    """Return the loop in libcosim."""
    return test_libcosim.run(native, TICKS)


HOSTS = {
    "C program, no Python": (c_host_lacks(), in_c, None),
    "libcosim": ("", in_libcosim, test_libcosim.DELAYS),
    "ecos": (ecos_lacks(), in_ecos, test_ecos.DELAYS),
}


def rows(bench):
    """Compare, and say so in the table."""
    native = NativeBench(bench.folder, bench.work)
    for host, (missing, simulate, delays) in HOSTS.items():
        found = None if missing else simulate(native)
        yield Row(
            kind="native FMUs in a closed loop",
            host=host,
            ran="not run"
            if found is None
            else f"fine pointing, {TICKS} ticks at own rates, {len(found.names)} outputs",
            agreement=f"{apart(native.reference(TICKS, delays), found):.0e}" if found else "",
            remark=missing or "against those in Python in lockstep, with the delays of the host",
        )


@pytest.mark.parametrize("host", HOSTS)
def test_native_loop_agrees_with_that_in_python(native, host):
    missing, simulate, delays = HOSTS[host]
    if missing:
        pytest.skip(missing)

    assert 0.0 < apart(native.reference(TICKS, delays), simulate(native)) < 1e-10


@pytest.mark.skipif(bool(c_host_lacks()), reason=c_host_lacks() or "available")
def test_loops_of_other_delays_differ(native):
    delays = {
        ("plant", "sensors"): 2,
        ("sensors", "plant"): 0,
        ("sensors", "controller"): 0,
        ("controller", "plant"): 0,
    }
    late = native.reference(TICKS, delays, configuration="distributed/native")
    assert apart(late, in_c(native)) > 1e-6
