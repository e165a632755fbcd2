"""Read what a library of Linux, Windows or macOS exports and needs."""

import io
import struct
from collections.abc import Iterator
from dataclasses import dataclass

from elftools.elf.elffile import ELFFile
from elftools.elf.gnuversions import GNUVerNeedSection


@dataclass(frozen=True, slots=True, kw_only=True)
class LibraryFacts:
    """What a library exports and needs.

    `machine` as its format numbers it; `versions`: of symbols of glibc, or the oldest macOS; `signed`: has a signature.
    """

    machine: int | str
    exports: frozenset[str]
    needed: frozenset[str]
    versions: tuple[tuple[int, ...], ...] = ()
    signed: bool = False


def elf_facts(content: bytes) -> LibraryFacts:
    """Read a library of Linux."""
    elf = ELFFile(io.BytesIO(content))
    symbols = [s for s in elf.get_section_by_name(".dynsym").iter_symbols() if s["st_shndx"] != "SHN_UNDEF" and s.name]
    tags = elf.get_section_by_name(".dynamic").iter_tags("DT_NEEDED")
    texts = [aux.name for section in elf.iter_sections() if isinstance(section, GNUVerNeedSection)
             for _, auxiliaries in section.iter_versions() for aux in auxiliaries]  # fmt: skip
    assert all(text.startswith("GLIBC_") for text in texts), texts
    return LibraryFacts(
        machine=elf["e_machine"],
        exports=frozenset(s.name for s in symbols),
        needed=frozenset(tag.needed for tag in tags),
        versions=tuple(tuple(map(int, text.removeprefix("GLIBC_").split("."))) for text in texts),
    )


def _text(content: bytes, start: int) -> str:
    return content[start : content.index(b"\0", start)].decode("ascii")


def windows_facts(content: bytes) -> LibraryFacts:
    """Read a library of Windows: the "PE format" of Microsoft's documentation, 64 bits."""
    assert content[:2] == b"MZ"
    (head,) = struct.unpack_from("<I", content, 0x3C)
    assert content[head : head + 4] == b"PE\0\0"
    machine, sections = struct.unpack_from("<HH", content, head + 4)
    (optional,) = struct.unpack_from("<H", content, head + 20)
    tables = struct.unpack_from("<4I", content, head + 24 + 112)  # exports, imports: address and size

    def place(address: int) -> int:
        for k in range(sections):
            size, start, _, raw = struct.unpack_from("<4I", content, head + 24 + optional + 40 * k + 8)
            if start <= address < start + size:
                return raw + address - start
        raise ValueError(hex(address))

    exports = place(tables[0])
    (count,) = struct.unpack_from("<I", content, exports + 24)
    (names,) = struct.unpack_from("<I", content, exports + 32)
    pointers = struct.unpack_from(f"<{count}I", content, place(names))
    needed, entry = [], place(tables[2])
    while any(content[entry : entry + 20]):
        needed.append(_text(content, place(struct.unpack_from("<I", content, entry + 12)[0])))
        entry += 20
    return LibraryFacts(
        machine=machine, exports=frozenset(_text(content, place(p)) for p in pointers), needed=frozenset(needed)
    )


def universal_parts(content: bytes) -> Iterator[bytes]:
    """Yield the libraries in a universal library of macOS, each at a multiple of what its row says."""
    magic, count = struct.unpack_from(">II", content)
    assert magic == 0xCAFEBABE
    for k in range(count):
        kind, _, start, size, alignment = struct.unpack_from(">iiIII", content, 8 + 20 * k)
        assert start % (1 << alignment) == 0
        part = content[start : start + size]
        assert struct.unpack_from("<Ii", part) == (0xFEEDFACF, kind)
        yield part


def macos_facts(content: bytes) -> LibraryFacts:
    """Read a library of macOS for one processor, as Apple's mach-o/loader.h describes it."""
    _, machine, _, kind, commands, *_ = struct.unpack_from("<Iii5I", content)
    assert kind == 6  # a dynamic library
    exports, needed, oldest, signed, place = set(), set(), (), False, 32
    for _ in range(commands):
        command, size = struct.unpack_from("<II", content, place)
        if command == 0x2:  # LC_SYMTAB
            symbols, count, texts, _ = struct.unpack_from("<4I", content, place + 8)
            for k in range(count):
                name, flags = struct.unpack_from("<IB", content, symbols + 16 * k)
                if flags & 0x01 and not flags & 0x10 and flags & 0x0E == 0x0E:  # external, not private, defined here
                    exports.add(_text(content, texts + name).removeprefix("_"))
        elif command == 0xC:  # LC_LOAD_DYLIB
            needed.add(_text(content, place + struct.unpack_from("<I", content, place + 8)[0]))
        elif command == 0x32:  # LC_BUILD_VERSION
            (version,) = struct.unpack_from("<I", content, place + 12)
            oldest = (version >> 16, version >> 8 & 0xFF)
        signed |= command == 0x1D  # LC_CODE_SIGNATURE
        place += size
    return LibraryFacts(machine=machine, exports=frozenset(exports), needed=frozenset(needed), versions=(oldest,),
                        signed=signed)  # fmt: skip
