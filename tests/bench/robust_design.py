"""Check the robust controller on the whole structure: `python tests/bench/robust_design.py [layout] [--curves]`.

Every corner at which it must be stable, with all 198 modes below 80 Hz (some minutes), points between the corners, its
exact margins there, fine pointing as covariances, and with `--curves` the trade-off, which
`flexsat figures --robust-design` draws. The published design is in the table beside.
"""

import sys

from flexbench.studies.margins.designed_loop import DesignedLoop
from flexbench.studies.margins.real_plant import Corner, Plants, stability
from flexbench.studies.margins.stability import stability_margins
from flexbench.studies.spillover.corners import drawn_points, points_between, required_corners
from flexbench.studies.spillover.stationary import stationary
from flexbench.studies.spillover.trade_off import HEADER, robust_trade_off
from flexsat.description.built_in import CONFIGURATIONS, configuration
from flexsat.design.chain import build_design
from flexsat.parameters import ALL_MODES, ARCSECOND
from flexsat.spacecraft.variation import ModelErrors

MARGIN_MODES = 60


def show(name: str) -> None:
    """Print the table of one layout."""
    published = Plants(build_design(configuration(name, "published")))
    plants = Plants(build_design(configuration(name, "robust")))
    print(f"{name}: growth rate of the slowest pole [1/s]; positive is unstable")
    for corner in required_corners(name):
        rates = [stability(each, corner).growth for each in (plants, published)]
        print(f"  {corner.title:62} robust {rates[0]:+9.4f}   published {rates[1]:+9.3f}", flush=True)
    print("  between the corners")
    for corner in points_between():
        print(f"  {corner.title:62} robust {stability(plants, corner).growth:+9.4f}", flush=True)
    drawn = [stability(plants, corner).growth for corner in drawn_points()]
    print(
        f"  {len(drawn)} points drawn within the errors, 198 modes: robust, largest growth {max(drawn):+9.4f}",
        flush=True,
    )
    for fine in (True, False):
        model = plants.model(ALL_MODES, ModelErrors())
        found = stationary(plants.design, model, plants.spacecraft.mass, fine=fine, jitter=fine)
        print(
            f"  {'fine guidance sensor, jitter' if fine else 'coarse star tracker, no jitter'}:"
            f" {found.pointing / ARCSECOND:.4f} arcsec, {found.torque:.4f} N.m, {1e6 * found.deformation:.4f} um"
        )
    coarse = stability(plants, Corner(modes=ALL_MODES), fine=False)
    print(f"  coarse star tracker: growth {coarse.growth:+.4f}")
    plant = plants.model(MARGIN_MODES, ModelErrors())
    print(f"  {stability_margins(DesignedLoop(design=plants.design, plant=plant).at)}", flush=True)


def curves(name: str) -> None:
    """Print the trade-off of one layout."""
    print(f"{name}, trade-off")
    print("  " + " | ".join(HEADER))
    for point in robust_trade_off(name):
        print("  " + " | ".join(point.row), flush=True)


if __name__ == "__main__":
    layouts = [name for name in CONFIGURATIONS if name in sys.argv[1:]] or CONFIGURATIONS
    for layout in layouts:
        (curves if "--curves" in sys.argv else show)(layout)
