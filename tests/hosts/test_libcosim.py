"""The systems in libcosim, loaded from the .ssp.

libcosim steps every slave whose turn it is, then transfers a value only when both its ends have completed their steps.
So a value between sensors and plant arrives a tick late; the controller sees measurements of the tick before; and what
it computes from them reaches the plant when its own step of five ticks is over. With these delays on the connections
lockstep must give the same bits.
"""

from hosting import TICK, Row, agreement, arcseconds_apart

DELAYS = {
    ("plant", "sensors"): 1,  # what is true now, as in the delivered systems
    ("sensors", "plant"): 1,
    ("sensors", "controller"): 1,
    ("controller", "plant"): 5,
}


def run(bench, ticks):
    """Return the trajectory that libcosim gives."""
    return bench.run(
        "run_libcosim.py",
        {
            "package": str(bench.package("fine_pointing")),
            "tick": TICK,
            "ticks": ticks,
            "references": bench.references(),
            "late": {"controller": 4},
        },
    )


def compared(bench, ticks=300):
    """Return the trajectory, and how it agrees with lockstep under the same delays."""
    found = run(bench, ticks)
    return found, agreement(bench.reference(ticks, DELAYS), found)


def rows(bench):
    """Compare, and say so in the table."""
    ticks = 300
    found, same = compared(bench, ticks)
    apart = arcseconds_apart(bench.reference(ticks), found)
    yield Row(
        kind="system of three (.ssp)",
        host="libcosim",
        ran=f"fine pointing, {ticks} ticks at own rates, {len(found.names)} outputs",
        agreement=same,
        remark=f"with libcosim's delays (torque 5 ticks, others 1); {apart:.1e} arcsec from lockstep without delays",
    )


def test_libcosim_agrees_bitwise_under_its_delays(bench):
    assert compared(bench)[1] == "bitwise"


def test_each_of_its_delays_matters(native):
    ticks, kind = 60, "distributed/native"
    found = run(native, ticks)
    # the measurements are held for five ticks, so that one or two ticks of delay are the same there
    others = [DELAYS | {ends: 0 if ends == ("sensors", "controller") else DELAYS[ends] + 1} for ends in DELAYS]
    same, *different = native.under_delays(ticks, [DELAYS, *others], configuration=kind)
    assert agreement(same, found) == "bitwise"
    assert [ends for ends, other in zip(DELAYS, different, strict=True) if agreement(other, found) == "bitwise"] == []
