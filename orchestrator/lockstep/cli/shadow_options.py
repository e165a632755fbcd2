"""Options of a shadow: a second FMU that runs beside a component, and may replace it during the run."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.options import option_group
from lockstep.cli.parameter_types import PATH
from lockstep.errors import InputError

if TYPE_CHECKING:
    from lockstep.system.system import System


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadowOptions:
    """The FMU, its adapter, and when it replaces the component."""

    shadow: str | None
    shadow_adapter: Path | None
    switchover: str | None
    blend: str | None

    def apply(self, system: System) -> System:
        """Return the system with the shadow, if there is to be one; or raise InputError."""
        from lockstep.adapter.read import read_adapter
        from lockstep.shadow.component import with_shadow
        from lockstep.system.clock import nanoseconds

        over = None if self.switchover is None else nanoseconds(self.switchover, "--switchover")
        blend = None if self.blend is None else nanoseconds(self.blend, "--blend")
        if self.shadow is None:
            self._refuse_without_shadow()
            return system
        if blend is not None and over is None:
            raise InputError(f"--blend {self.blend}: needs --switchover SECONDS as well")
        match = re.fullmatch(r"([^=.]+)=(.+)", self.shadow)
        if match is None:
            raise InputError(f"--shadow {self.shadow}: write COMPONENT=FMU, for example controller=vendor.fmu")
        adapter = None if self.shadow_adapter is None else read_adapter(self.shadow_adapter)
        return with_shadow(system, match[1], Path(match[2]), adapter, over, blend)

    def _refuse_without_shadow(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None:
                raise InputError(f"--{field.name.replace('_', '-')} {value}: needs --shadow COMPONENT=FMU as well")


shadow_options = option_group(
    "shadow",
    ShadowOptions,
    click.option("--shadow", metavar="C=FMU",
                 help="run a second FMU in shadow of component C; its parameters are C.shadow.P"),
    click.option("--shadow-adapter", type=PATH, metavar="FILE", help="TOML file between the shadow and the ports of C"),
    click.option("--switchover", metavar="S", help="time at which the shadow replaces C (default: never)"),
    click.option("--blend", metavar="S",
                 help="time in which the difference of both outputs decays afterwards; 0: at once (default: 5)"),
)  # fmt: skip
