"""Write a file whole or not at all; compute the digest of one."""

import errno
import hashlib
import secrets
from pathlib import Path

DISK_FULL = (errno.ENOSPC, errno.EDQUOT)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file, and its folder if there is none, so that a reader sees the old one or the new one.

    Raises OSError with the path.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name[:200]}.{secrets.token_hex(4)}")
    try:
        with partial.open("xb", buffering=0) as file:  # with a buffer, a full disk shows when the file is closed
            rest = memoryview(content)
            while rest:
                rest = rest[file.write(rest) :]
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror or str(error), str(path)) from None
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file, read in pieces; raise OSError."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
