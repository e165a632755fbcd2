"""Lists of the figures of a design and of runs, each drawn when it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from flexbench.loop.systems import build_system
from flexbench.runs.run_folder import Run
from flexsat.closed_loop import PORTS, port_values
from flexsat.design.chain import Designs
from flexsat.parameters import ConfigurationName
from flexsat.variants import CORRECTED, Variant
from lockstep import Signals
from lockstep.faults.windows import fault_windows

from .architecture import architecture_diagram
from .campbell import campbell_diagram
from .drawing import save_figure
from .faults import shade_faults
from .fine_pointing import fine_pointing_comparison
from .modes import mode_shapes
from .slew import slew_comparison
from .software import software_diagram
from .structure import structure_layout
from .wheels import wheel_responses

Drawn = dict[str, Callable[[], Figure]]  # name of the file, and what draws it


def design_figures(designs: Mapping[ConfigurationName, Designs], variant: Variant = CORRECTED) -> Drawn:
    """Return the figures that need no run, each drawn when called.

    Parameters
    ----------
    designs : by configuration, one at least
    variant : whose design is drawn; what is the same for all variants is drawn with the corrected one alone
    """
    chosen = {name: every.variant(variant) for name, every in designs.items()}
    mark, whole = variant.mark, variant == CORRECTED
    drawn: Drawn = {"structure": lambda: structure_layout(chosen)} if whole else {}
    first = next(iter(chosen.values()))
    if first.config.aperture is not None:
        drawn[f"mode-shapes{mark}"] = lambda: mode_shapes(first)  # one structure
    drawn[f"campbell{mark}"] = lambda: campbell_diagram(chosen)
    if whole:
        drawn["software"] = software_diagram
    for name, every in designs.items():
        drawn[f"wheel-responses-{name}{mark}"] = partial(wheel_responses, chosen[name])
        if whole:
            drawn[f"architecture-{name}"] = partial(architecture, every)
    return drawn


def architecture(designs: Designs) -> Figure:
    """Draw the architecture of flexsat's closed loop, the same for every scenario."""
    config, craft = designs.corrected.config, designs.corrected.spacecraft
    system = replace(build_system(designs, "fine_pointing", Path()), name=f"closed loop, {config.name}")
    starts = port_values("sensors", PORTS["sensors"](designs.corrected.sensors), {})
    fast, tracker = (1e3 * starts[name] for name in ("fast_period", "star_tracker.period"))
    notes = {
        "sensors": (
            "gyros, accelerometers,", f"encoders every {fast:g} ms,", f"star tracker every {tracker:g} ms;",
            f"jitter of {craft.wheel_count} wheels",
        ),
        "controller": (
            "slew guidance, LQR,", "Kalman filter with", f"{len(designs.corrected.fine.gain)} gains in turn;",
            "torque limits,", "delay compensation",
        ),
        "plant": ("rigid body,", f"{designs.corrected.structure.mode_count} modes, {craft.wheel_count} wheels"),
    }  # fmt: skip
    return architecture_diagram(system, notes)


def result_figures(runs: Sequence[Run]) -> Drawn:
    """Return the figures of runs, each drawn when called: slews, and fine pointing with the loop open and closed.

    Runs of both configurations with one seed, in one variant, share a figure; a second run of a kind gets its own.
    """
    groups: dict[str, dict[tuple[ConfigurationName, bool], Run]] = {}
    for run in runs:
        stem = "slew" if run.slew else "fine-pointing"
        stem += f"{run.variant.mark}-seed{run.seed}"
        member = (run.configuration, run.open_loop and not run.slew)
        name, number = stem, 1
        while member in groups.setdefault(name, {}):
            number += 1
            name = f"{stem}-{number}"
        groups[name][member] = run
    return {
        name: partial(_slew if name.startswith("slew") else _fine_pointing, group) for name, group in groups.items()
    }


def save_figures(drawn: Drawn, folder: Path) -> list[Path]:
    """Draw figures one after another into a folder, PNG and SVG; return their paths."""
    return [path for name, draw in drawn.items() for path in save_figure(draw(), folder, name)]


def _slew(group: Mapping[tuple[ConfigurationName, bool], Run]) -> Figure:
    runs = {name: run for (name, _), run in group.items()}
    figure = slew_comparison(
        {name: run.signals() for name, run in runs.items()}, {name: run.flown for name, run in runs.items()}
    )
    return _shaded(figure, group)


def _fine_pointing(group: Mapping[tuple[ConfigurationName, bool], Run]) -> Figure:
    closed, opened = (_signals(group, open_loop=loop) for loop in (False, True))
    return _shaded(fine_pointing_comparison(closed, opened), group)


def _shaded(figure: Figure, group: Mapping[tuple[ConfigurationName, bool], Run]) -> Figure:
    """Shade when faults acted, with the names of the configurations if they had others."""
    windows = [(name, fault_windows(run.folder)) for (name, _), run in group.items()]
    listed = [[(window.name, window.begin, window.end) for window in found] for _, found in windows]
    if all(one == listed[0] for one in listed):
        return shade_faults(figure, windows[0][1])
    named = [replace(window, name=f"{name}: {window.name}") for name, found in windows for window in found]
    return shade_faults(figure, named)


def _signals(
    group: Mapping[tuple[ConfigurationName, bool], Run], *, open_loop: bool
) -> dict[ConfigurationName, Signals]:
    return {name: run.signals() for (name, opened), run in group.items() if opened == open_loop}
