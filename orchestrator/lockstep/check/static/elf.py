"""Read an ELF library: machine, exported and needed symbols, needed libraries."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from elftools.common.exceptions import ELFError
from elftools.elf.elffile import ELFFile

MACHINE, BITS = "EM_X86_64", 64  # of linux64


@dataclass(frozen=True, slots=True, kw_only=True)
class Library:
    """One shared library."""

    machine: str
    bits: int
    shared: bool
    exported: frozenset[str]
    undefined: frozenset[str]  # that must be found when it is loaded; weak ones may stay undefined
    needed: tuple[str, ...]
    paths: tuple[str, ...]  # RPATH or RUNPATH, as written
    versions: Mapping[str, str] = field(default_factory=dict)  # newest symbol version needed, such as GLIBC: 2.34


def read_library(content: bytes) -> Library:
    """Read a library; raise ValueError if it is none."""
    try:
        elf = ELFFile(io.BytesIO(content))
        symbols = list(_symbols(elf))
        dynamic: Any = elf.get_section_by_name(".dynamic")
        tags = [] if dynamic is None else list(dynamic.iter_tags())
        paths = [getattr(tag, "rpath", "") or getattr(tag, "runpath", "") for tag in tags]
        return Library(
            machine=str(elf["e_machine"]),
            bits=int(elf.elfclass),
            shared=elf["e_type"] == "ET_DYN",
            exported=frozenset(
                s.name for s in symbols if s["st_shndx"] != "SHN_UNDEF" and s["st_info"]["bind"] != "STB_LOCAL"
            ),
            undefined=frozenset(
                s.name for s in symbols if s["st_shndx"] == "SHN_UNDEF" and s["st_info"]["bind"] == "STB_GLOBAL"
            ),
            needed=tuple(tag.needed for tag in tags if tag.entry.d_tag == "DT_NEEDED"),
            paths=tuple(part for text in paths for part in text.split(":") if part),
            versions=_versions(elf),
        )
    except (ELFError, KeyError, IndexError, OverflowError, UnicodeDecodeError, AttributeError) as error:
        raise ValueError(f"not a readable ELF file: {error}") from None


def _symbols(elf: Any) -> Iterator[Any]:
    section = elf.get_section_by_name(".dynsym")
    return iter(()) if section is None else section.iter_symbols()


def _versions(elf: Any) -> dict[str, str]:
    section = elf.get_section_by_name(".gnu.version_r")
    newest: dict[str, str] = {}
    for _, versions in () if section is None else section.iter_versions():
        for version in versions:
            name, _, value = version.name.partition("_")
            if value[:1].isdigit():
                newest[name] = max(newest.get(name, "0"), value, key=_ordered)
    return newest


def _ordered(version: str) -> list[int]:
    return [int(part) for part in version.split(".") if part.isdigit()]


def find_library(name: str, paths: tuple[Path, ...] = ()) -> Path | None:
    """Find a needed library in these folders, then where the system's loader looks."""
    if "/" in name:
        return Path(name) if Path(name).is_file() else None
    return next((folder / name for folder in (*paths, *_folders()) if (folder / name).is_file()), None)


@cache
def _folders() -> tuple[Path, ...]:
    given = [Path(part) for part in os.environ.get("LD_LIBRARY_PATH", "").split(":") if part]
    for file in sorted(Path("/etc/ld.so.conf.d").glob("*.conf")):
        lines = file.read_text(encoding="utf-8", errors="replace").splitlines()
        given += [Path(line.strip()) for line in lines if line.startswith("/")]
    system = ("/lib/x86_64-linux-gnu", "/usr/lib/x86_64-linux-gnu", "/lib64", "/usr/lib64", "/lib", "/usr/lib")
    return tuple(dict.fromkeys([*given, *map(Path, system)]))


@cache
def exported_with_dependencies(path: Path) -> frozenset[str]:
    """Return what a library of this system exports, with all that it loads."""
    found: set[str] = set()
    waiting, seen = [path], set()
    while waiting:
        current = waiting.pop()
        if current in seen:
            continue
        seen.add(current)
        try:
            library = read_library(current.read_bytes())
        except (OSError, ValueError):  # a linker script, or not readable: its symbols are unknown
            continue
        found |= library.exported
        waiting += [p for name in library.needed if (p := find_library(name, (current.parent,))) is not None]
    return frozenset(found)
