"""Which FMUs a build makes beside those in Python, and for which platforms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flexsat.ports.table import FmiVersion


@dataclass(frozen=True, slots=True, kw_only=True)
class BuildOptions:
    """What to build; by default what `flexsat build` builds without options.

    Attributes
    ----------
    in_c : FMI versions of the FMUs in C; each version has systems in a folder of its own
    platforms : of the FMUs in C, as in flexsat.fmu.native.platforms; none for Linux x86-64 with this machine's compiler
    flat : also FMUs with flat variable names, and systems of them, in a folder of their own
    execution_tool : declare that the FMUs in Python need a tool to be executed
    """

    in_c: tuple[FmiVersion, ...] = ("2.0",)
    platforms: Sequence[str] = ()
    flat: bool = False
    execution_tool: bool = False


STANDARD = BuildOptions()
ONLY_PYTHON = BuildOptions(in_c=())
