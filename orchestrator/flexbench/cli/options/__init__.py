"""Options that commands of `flexsat` share: seeds, configurations, scenarios, folders of FMUs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from lockstep.cli.options import Decorator
from lockstep.cli.parameter_types import COUNT, PATH, SEED
from lockstep.errors import InputError

if TYPE_CHECKING:
    from flexsat.parameters import ConfigurationName
    from flexsat.variants import Variant
    from lockstep.system.component import Value
    from lockstep.system.system import System

DEFAULT_SEED = 1  # of every command that simulates
CONFIGURATIONS = ("centralised", "distributed")  # as in flexsat.parameters, which the help does not wait for
SCENARIOS = ("slew", "fine_pointing", "fine_pointing_open_loop")  # as in flexbench.loop.scenarios
ACCEPT_INFEASIBLE = "--accept-infeasible"  # as in flexbench.loop.feasibility
_SEEDED = ("plant", "sensors")  # components with a parameter `seed`

spacecraft_option = click.option(
    "--configuration",
    multiple=True,
    metavar="NAME",
    help="centralised, distributed, a spacecraft's file, or a folder of its FMUs (default: the first two)",
)
fmus_option = click.option(
    "--fmus", type=PATH, default="fmus", metavar="DIR", help="folder of the FMUs (default: fmus)"
)
seed_option = click.option("--seed", type=SEED, metavar="N",
                           help=f"seed of plant and sensors (default: {DEFAULT_SEED})")  # fmt: skip
python_option = click.option(
    "--python", is_flag=True, help="use the FMUs in Python (default: the native ones, where they are built)"
)


def variant_option(help_text: str) -> Decorator:
    """Return the option that chooses the release's variant, in place of the corrected one."""

    def variant(_context: click.Context, _option: click.Parameter, released: bool) -> Variant:
        from flexsat.variants import AS_PUBLISHED, CORRECTED

        return AS_PUBLISHED if released else CORRECTED

    return click.option("--as-published", "variant", is_flag=True, callback=variant, help=help_text)


SETTLED_HELP = "evaluate from this time in seconds (default: settled after a slew; else 150, or half of a short run)"


def seeds_option(default: int) -> Decorator:
    """Return the option of the number of seeds."""
    last = f"{DEFAULT_SEED} to N"
    return click.option("--seeds", "seed_count", type=COUNT, default=default, metavar="N",
                        help=f"simulate seeds {last} (default: {default})")  # fmt: skip


def seeds(count: int) -> range:
    """Return that many seeds."""
    return range(DEFAULT_SEED, DEFAULT_SEED + count)


def configurations(chosen: Sequence[str]) -> tuple[ConfigurationName, ...]:
    """Return the chosen built-in configurations in the usual order, all if none is chosen; InputError for others."""
    from flexsat.description.built_in import CONFIGURATIONS as ALL

    for name in chosen:
        if name not in ALL:
            raise InputError(f"--configuration: '{name}' is none of {', '.join(ALL)}")

    return tuple(name for name in ALL if name in (chosen or ALL))


def seed_overrides(system: System, seed: int | None) -> dict[str, Value]:
    """Return the parameters that set the seed of plant and sensors, wherever they are in a system.

    The default seed is for those that have a seed and are not given one by the system file: the plant of another maker
    may have none.
    """
    names = [c.name for part in _SEEDED for c in system.components if c.name.rpartition("/")[2] == part]
    if seed is not None:
        return {f"{name}.seed": seed for name in names or _SEEDED}
    return {f"{name}.seed": DEFAULT_SEED for name in names if _has_free_seed(system, name)}


def _has_free_seed(system: System, name: str) -> bool:
    """Return whether a component has a parameter `seed` without a value of the system's."""
    from lockstep.fmi.model_description import read_description

    component = system.component(name)
    variable = read_description(component).variables.get("seed")
    return variable is not None and variable.causality == "parameter" and "seed" not in component.parameters
