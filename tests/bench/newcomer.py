"""Play the newcomer on a bare image: `python tests/bench/newcomer.py IMAGE LOG` (root only, Linux).

IMAGE is a folder with a minimal system, which the newcomer's files are added to, for example

    debootstrap --variant=minbase --include=python3,python3-venv,make,gcc,libc6-dev,git,ca-certificates bookworm IMAGE

In it, as a user with an empty home would: clone this repository at its last commit, give the README's commands in
their order, then those of the tutorials, each in a shell with `.venv` activated, at a terminal of 100 columns. LOG is
what that terminal showed, with the time of each command; a table of the times ends it. Exit code 1 if a command did not
end as its page says. `make test` takes long and needs more programs: it is given with `--test` only.
"""

from __future__ import annotations

import argparse
import fcntl
import os
import pty
import re
import shlex
import shutil
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from typing import TextIO

ROOT = Path(__file__).parents[2]
PAGES = (
    "README.md",
    *(f"docs/{name}.md" for name in ("first_run", "controller_in_the_loop", "first_campaign", "fmus_for_other_tools",
                                     "own_spacecraft_first_hour")),
)  # fmt: skip
BLOCK = re.compile(r"^(?:<!-- exit code (\d) -->\n)?```(sh|python)\n(.*?)^```", re.DOTALL | re.MULTILINE)
CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]|\x1b[=>]")
CERTIFICATES = "etc/ssl/certs/ca-certificates.crt"
PATHS = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
COLUMNS = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """What the newcomer types: one shell command, or a block of Python."""

    page: str
    text: str
    code: int = 0  # the exit code that the page says
    language: str = "sh"
    folder: str = "/root/flexsat"
    activated: bool = True

    def script(self) -> str:
        """Return it as a script of bash."""
        lines = [f"cd {self.folder}"]
        if self.activated:
            lines.append("source .venv/bin/activate")
        lines.append(self.text if self.language == "sh" else f"python -c {shlex.quote(self.text)}")
        return "\n".join(lines)


def commands(test: bool) -> Iterator[Command]:
    """Yield the newcomer's commands."""
    yield Command(page="", text="git clone /repository flexsat", folder="/root", activated=False)
    for target in ("run", "test")[: 2 if test else 1]:
        yield Command(page="README.md", text=f"make {target}", activated=False)
    for page in PAGES:
        for code, language, block in BLOCK.findall((ROOT / page).read_text(encoding="utf-8")):
            expected = int(code or 0)
            if language == "sh" and "<<" not in block:
                for line in block.replace("\\\n", "").splitlines():
                    yield Command(page=page, text=line, code=expected)
            else:
                yield Command(page=page, text=block, code=expected, language=language)


def prepare(image: Path, certificates: Path | None) -> None:
    """Give the image names of hosts, certificates of the network it is in, and an empty home."""
    shutil.rmtree(image / "root" / "flexsat", ignore_errors=True)
    shutil.copy("/etc/resolv.conf", image / "etc/resolv.conf")
    shutil.copy("/etc/hosts", image / "etc/hosts")
    if certificates is not None:
        shutil.copy(certificates, image / CERTIFICATES)
    (image / "repository").mkdir(exist_ok=True)


def give(command: Command, image: Path, log: TextIO) -> int:
    """Give a command at a terminal inside the image; return its exit code."""
    inside = shlex.quote(str(image))
    mounted = (
        f"mount --bind {shlex.quote(str(ROOT))} {inside}/repository && mount --rbind /dev {inside}/dev && "
        f"mount -t proc proc {inside}/proc && exec chroot {inside} /usr/bin/env -i HOME=/root TERM=dumb "
        f"COLUMNS={COLUMNS} PATH={PATHS} SSL_CERT_FILE=/{CERTIFICATES} bash -e -c {shlex.quote(command.script())}"
    )
    process, terminal = pty.fork()
    if process == 0:
        os.execvp("unshare", ["unshare", "--mount", "--pid", "--fork", "--kill-child", "sh", "-c", mounted])
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 40, COLUMNS, 0, 0))
    shown = b""
    while True:
        try:
            read = os.read(terminal, 65536)
        except OSError:  # the other end is closed
            break
        if not read:
            break
        shown += read
    os.close(terminal)
    status = os.waitpid(process, 0)[1]
    text = CONTROL.sub("", shown.decode(errors="replace").replace("\r\n", "\n"))
    log.writelines(f"{line.rsplit(chr(13), 1)[-1]}\n" for line in text.split("\n"))
    return os.waitstatus_to_exitcode(status)


def times() -> float:
    """Return the processor time of ended children [s]."""
    used = getrusage(RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> int:
    """Play the newcomer."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("image", type=Path)
    parser.add_argument("log", type=Path)
    parser.add_argument("--test", action="store_true", help="`make test` too")
    parser.add_argument("--only", nargs="*", default=None, metavar="PAGE",
                        help="pages whose commands are given, in the clone of an earlier call")  # fmt: skip
    parser.add_argument("--certificates", type=Path, default=os.environ.get("SSL_CERT_FILE"),
                        help="of a network with an authority of its own (default: $SSL_CERT_FILE)")  # fmt: skip
    given = parser.parse_args()
    image = given.image.absolute()
    chosen = [one for one in commands(given.test) if given.only is None or one.page in given.only]
    if given.only is None:
        prepare(image, given.certificates)
    commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    table, wrong = [], 0
    with given.log.open("w", encoding="utf-8", buffering=1) as log:
        log.write(f"commit {commit}")
        for command in chosen:
            log.write(
                f"\n[{time.strftime('%H:%M:%S')}] {command.page or 'before the README'}\n$ {command.text.strip()}\n"
            )
            began, used = time.monotonic(), times()
            code = give(command, image, log)
            wall, used = time.monotonic() - began, times() - used
            right = code == command.code
            wrong += not right
            log.write(f"[{wall:.1f} s, {used:.1f} s of processor time, exit code {code}{'' if right else ': WRONG'}]\n")
            first = command.text.strip().partition("\n")[0]
            table.append(f"{wall:8.1f} {used:8.1f} {code:4}{'  ' if right else ' !'} {command.page:32} {first[:100]}\n")
        log.write("\n    wall processor code  page and command\n")
        log.writelines(table)
    print(f"{given.log}: {len(chosen)} commands, {wrong} not as their page says")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
