"""The platforms that bundles are built for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class BundlePlatform:
    """A platform: the folders below binaries/ that FMUs may have, and the suffix.

    `target` is how Zig names the oldest system that the library runs on.
    """

    folders: Mapping[str, tuple[str, ...]]  # by version of FMI; the first is that of a bundle
    suffix: str
    target: str


VERSIONS = ("2.0", "3.0")  # of FMI, for a bundle and what it holds
_ARM = ("aarch64-linux",)
PLATFORMS = {
    "linux64": BundlePlatform(
        folders={"2.0": ("linux64",), "3.0": ("x86_64-linux",)}, suffix=".so", target="x86_64-linux-gnu.2.17"
    ),
    "win64": BundlePlatform(
        folders={"2.0": ("win64",), "3.0": ("x86_64-windows",)}, suffix=".dll", target="x86_64-windows-gnu"
    ),
    "aarch64-linux": BundlePlatform(
        folders={"2.0": (*_ARM, "linux64"), "3.0": _ARM}, suffix=".so", target="aarch64-linux-gnu.2.17"
    ),
}
