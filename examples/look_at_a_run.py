"""Look at a run from Python: load it as an xarray Dataset, pick signals by name, and compute with units at hand.

    python examples/look_at_a_run.py results/distributed-fine-pointing

Make a run first: `flexsat build`, then `flexsat run fmus/distributed/fine_pointing.ssd --stop-time 30`.
"""

import sys

import numpy as np

import flexbench


def main(folder: str) -> None:
    """Print what a run holds, and a few numbers of it."""
    run = flexbench.load(folder)
    print(f"{run.attrs['system']}, seed {run.attrs.get('seed', '-')}, {run.attrs['versions']}")
    for name, signal in run.data_vars.items():
        shape = " x ".join(f"{count} {dimension}" for dimension, count in signal.sizes.items())
        print(f"  {name:42} {shape:28} [{signal.attrs['units']}]  {signal.attrs['description']}")

    # an array of signals is one variable: pick by the index that the FMU uses, and by time in seconds
    torque = run["controller.wheel.torque"]
    busiest = int(torque["wheel"][np.abs(torque).max("time").argmax("wheel")])
    late = torque.sel(wheel=busiest).sel(time=slice(1.0, None))
    print(f"largest torque: wheel {busiest}, {float(np.abs(torque).max()):.3g} {torque.attrs['units']}")
    print(f"its RMS from 1 s on: {float(np.sqrt((late**2).mean())):.3g} {torque.attrs['units']}")

    # the deformation a second at a time
    deformation = run["plant.rms_deformation"]
    seconds = deformation.groupby(np.floor(deformation["time"]).rename("second")).max()
    print(f"largest deformation in each of the first 5 s: {(seconds[:5] * 1e6).round(3).values.tolist()} um")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
