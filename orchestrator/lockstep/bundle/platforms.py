"""The platforms that bundles are built for."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class BundlePlatform:
    """A platform: the folders below binaries/ that FMUs may have, the first that of the bundle, and the suffix.

    `target` is how Zig names the oldest system that the library runs on.
    """

    folders: tuple[str, ...]
    suffix: str
    target: str


PLATFORMS = {
    "linux64": BundlePlatform(folders=("linux64",), suffix=".so", target="x86_64-linux-gnu.2.17"),
    "win64": BundlePlatform(folders=("win64",), suffix=".dll", target="x86_64-windows-gnu"),
    "aarch64-linux": BundlePlatform(
        folders=("aarch64-linux", "linux64"), suffix=".so", target="aarch64-linux-gnu.2.17"
    ),
}
