"""The options of a shadow on a command line."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from lockstep.adapter.read import read_adapter
from lockstep.errors import InputError
from lockstep.shadow.component import recorded, with_shadow
from lockstep.system.clock import nanoseconds
from lockstep.system.system import System


def add_shadow_options(parser: argparse.ArgumentParser) -> None:
    """Add what tells of a shadow and of the hand-over."""
    add = parser.add_argument
    add("--shadow", metavar="C=FMU", help="a second FMU rides along beside C; set its parameters as C.shadow.P")
    add("--shadow-adapter", type=Path, metavar="FILE", help="TOML file between the shadow and the ports of C")
    add("--hand-over", metavar="S", help="time at which the shadow takes over (default: never)")
    add("--blend", metavar="S", help="how long the difference then takes to pass; 0 jumps (default: 5)")


def shadow_as_told(options: argparse.Namespace, system: System) -> System:
    """Return the system with the shadow that the options ask for, if they do."""
    over = None if options.hand_over is None else nanoseconds(options.hand_over, "--hand-over")
    blend = None if options.blend is None else nanoseconds(options.blend, "--blend")
    if options.shadow is None:
        for name in ("shadow_adapter", "hand_over", "blend"):
            if getattr(options, name) is not None:
                option = f"--{name.replace('_', '-')} {getattr(options, name)}"
                raise InputError(f"{option}: needs --shadow COMPONENT=FMU beside it")
        return system
    if blend is not None and over is None:
        raise InputError(f"--blend {options.blend}: needs --hand-over SECONDS beside it")
    match = re.fullmatch(r"([^=.]+)=(.+)", options.shadow)
    if match is None:
        raise InputError(f"--shadow {options.shadow}: write COMPONENT=FMU, for example controller=vendor.fmu")
    adapter = None if options.shadow_adapter is None else read_adapter(options.shadow_adapter)
    return with_shadow(system, match[1], Path(match[2]), adapter, over, blend)


def record_as_told(options: argparse.Namespace, system: System) -> list[str] | None:
    """Return the patterns to record: those asked for, and always what a shadow is judged by."""
    if options.record is None:
        return None
    return [*options.record, *(pattern for component in system.components for pattern in recorded(component))]
