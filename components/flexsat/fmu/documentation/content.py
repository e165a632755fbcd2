"""Gather what travels in an FMU beside its code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...parameters import Configuration
from ...ports.table import PortTable
from ...spacecraft.assembly import Spacecraft
from .controller_text import CONTROLLER
from .drawing import icon, model_picture
from .hosting import DEPENDENCIES
from .licences import licence_files
from .page import page
from .plant_text import PLANT
from .reference_results import Run, reference_files
from .sensors_text import SENSORS
from .terminals import terminals_xml
from .text import ComponentText

TEXTS: dict[str, ComponentText] = {"plant": PLANT, "sensors": SENSORS, "controller": CONTROLLER}
_REPLAY = """\
How to replay the experiments of extra/org.fmi-standard.fmi-ls-ref/
===================================================================

experiments.exp lists them: each has reference results, most have parameters and stimuli.

1. Instantiate. Set the parameters of <name>-parameters.ssv; what is not in it keeps its start value.
2. Initialise at time 0, the inputs of the first row of <name>-stimuli.csv set in initialisation mode.
3. For each row of the stimuli, at time t: set the inputs, then doStep(t, stepSize). There is a row for each step, so
   nothing needs to be interpolated; an experiment without stimuli sets no input and takes stopTime/stepSize steps.
4. <name>-references.csv has what the outputs read at its times: after initialisation at time 0, and after the steps
   that end there, before new inputs are set. It has fewer rows than steps were taken.

Booleans are 0 and 1. Numbers are written with as many digits as give the same bits when read.

How near must it be? With the same numpy on the same kind of processor, the results are equal bit by bit. Others add
in another order: what differs then is rounding. 1e-9 of the largest value of an array of outputs is a good bound to
check with; a wrong wiring, unit, parameter or time of reading is off by far more. A host that interpolates the stimuli
between rows, and meets a row at a time that differs in its last digit, stays within the same bound.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Travelling:
    """Files of an FMU: below documentation/, and at other places in the archive."""

    documentation: dict[str, bytes]
    extra: dict[str, bytes]


def travelling(
    component: str,
    table: PortTable,
    runs: Sequence[Run],
    pictures: Mapping[str, bytes],
    *,
    config: Configuration,
    model_name: str,
    version: str,
    step: float,
    stop: float,
) -> Travelling:
    """Return what travels in one FMU, with names in the naming of the table.

    Parameters
    ----------
    component : plant, sensors or controller
    runs : its experiments, already run
    pictures : from `draw`
    step, stop : of the default experiment [s]
    """
    experiments = [run.experiment for run in runs]
    index = page(
        table,
        TEXTS[component],
        experiments,
        model_name=model_name,
        configuration=_layout(config),
        version=version,
        step=step,
        stop=stop,
    )
    documentation = {
        "index.html": index,
        "externalDependencies.txt": DEPENDENCIES.encode(),
        "fmi-ls-ref.txt": _REPLAY.encode(),
        **{f"licenses/{name}": content for name, content in licence_files().items()},
    }
    terminals = {"terminalsAndIcons/terminalsAndIcons.xml": terminals_xml(table)}
    return Travelling(documentation=documentation, extra={**pictures, **terminals, **reference_files(table, runs)})


def draw(spacecraft: Spacecraft, config: Configuration, component: str) -> dict[str, bytes]:
    """Return the pictures of an FMU by their place in the archive."""
    return {
        "model.png": model_picture(spacecraft, component, config.aperture),
        "terminalsAndIcons/icon.png": icon(spacecraft, component, config.aperture),
    }


def _layout(config: Configuration) -> str:
    wheel = f"{config.wheel.inertia:.3g} kg.m2 and {config.wheel.torque_limit:.3g} N.m each"
    if config.wheels_at_sites:
        return f"This one carries 33 small wheels ({wheel}), three on the bus and three at each of ten sites."
    return f"This one carries six large wheels on the bus ({wheel})."
