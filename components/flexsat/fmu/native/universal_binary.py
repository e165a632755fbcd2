"""Join libraries for several processors into one universal library of macOS.

The format is that of Apple's `mach-o/fat.h`: a table, big-endian, and the libraries whole, each at a multiple of the
page size of its processor. The signature of a library, which macOS wants on ARM, stays valid, being part of it.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping

_MAGIC = 0xCAFEBABE
_HEAD, _ROW = struct.Struct(">II"), struct.Struct(">iiIII")
_PROCESSORS = {  # type and subtype, and the power of two that a library is aligned to
    "x86_64-darwin": (0x01000007, 3, 12),
    "aarch64-darwin": (0x0100000C, 0, 14),
}


def universal_binary(libraries: Mapping[str, bytes]) -> bytes:
    """Return one library from those of several processors.

    Parameters
    ----------
    libraries : by tuple of FMI 3.0: x86_64-darwin, aarch64-darwin
    """
    table = _HEAD.pack(_MAGIC, len(libraries))
    content = bytearray(_HEAD.size + _ROW.size * len(libraries))
    for target, library in libraries.items():
        kind, subkind, alignment = _PROCESSORS[target]
        content += bytes(-len(content) % (1 << alignment))
        table += _ROW.pack(kind, subkind, len(content), len(library), alignment)
        content += library
    content[: len(table)] = table
    return bytes(content)
