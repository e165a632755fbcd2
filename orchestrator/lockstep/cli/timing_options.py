"""Options of step sizes, delays and kinds of components, which system files of other tools do not contain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from lockstep.cli.options import option_group, refuse_repeated
from lockstep.errors import InputError
from lockstep.tick import IMPLEMENTATIONS

if TYPE_CHECKING:
    from lockstep.ssp.step_times import Timing
    from lockstep.system.clock import Time
    from lockstep.system.component import Kind
    from lockstep.system.system import System


@dataclass(frozen=True, slots=True, kw_only=True)
class TimingOptions:
    """Step sizes, delays and kinds, as text."""

    delay: tuple[str, ...]
    step_size: tuple[str, ...]
    tick: tuple[str, ...]  # of the base tick, and of what executes ticks
    continuous: tuple[str, ...]
    sampled: tuple[str, ...]

    def timing(self) -> Timing:
        """Return what `load_system` needs of them, or raise InputError."""
        from lockstep.ssp.step_times import Timing

        sizes = [text.rpartition("=") for text in self.step_size]
        refuse_repeated(self.step_size, "--step-size")
        delays = [text for text in self.delay if "=" not in text]
        kinds: dict[str, Kind] = dict.fromkeys(self.continuous, "continuous")
        both = sorted(kinds.keys() & set(self.sampled))
        if both:
            raise InputError(f"--sampled {both[0]}: --continuous names it too; choose one")
        kinds |= dict.fromkeys(self.sampled, "sampled")
        general = [size for name, _, size in sizes if not name]
        ticks = [text for text in self.tick if text not in IMPLEMENTATIONS]
        if len(ticks) > 1:
            raise InputError(f"--tick {ticks[-1]}: given already, as {ticks[0]}; give one base tick")
        for option, texts in (("--step-size", general), ("--delay", delays)):
            if len(texts) > 1:
                raise InputError(f"{option} {texts[-1]}: given for all already, as {texts[0]}; name a component")
        return Timing(
            tick=_positive(ticks[0], "--tick") if ticks else None,
            period=_positive(general[0], "--step-size") if general else None,
            periods={name: _positive(size, f"--step-size {name}") for name, _, size in sizes if name},
            kinds=kinds,
            delay=_ticks(delays[0]) if delays else None,
        )


def implementation(texts: Sequence[str]) -> str:
    """Return what is to execute ticks, of the values of --tick: auto, python or c; or raise InputError."""
    words = [text for text in texts if text in IMPLEMENTATIONS]
    if len(set(words)) > 1:
        raise InputError(f"--tick {words[-1]}: given already, as {words[0]}; choose one")
    return words[0] if words else "auto"


timing_options = option_group(
    "timing",
    TimingOptions,
    click.option("--delay", multiple=True, metavar="[A:B=]N",
                 help="delay of the connections from A to B, or of all connections, in ticks"),
    click.option("--step-size", multiple=True, metavar="[C=]S",
                 help="co-simulation step of component C, or a pattern, or of all, in seconds, or as a fraction: 1/60"),
    click.option("--tick", multiple=True, metavar="S|python|c",
                 help="base tick in seconds, for system files without one; or the code that executes the ticks, with "
                      "equal results (default: auto, which is C where there is a compiler)"),
    click.option("--continuous", multiple=True, metavar="C", help="outputs of C are true at the end of its step"),
    click.option("--sampled", multiple=True, metavar="C", help="outputs of C hold from the start of its step"),
)  # fmt: skip


def with_delays(system: System, texts: Sequence[str]) -> System:
    """Return the system with delays given as TICKS for all connections, and as FROM:TO=TICKS, which goes before."""
    refuse_repeated(texts, "--delay")
    for text in sorted(texts, key=lambda text: "=" in text):
        ends, equals, ticks = text.rpartition("=")
        start, _, end = ends.partition(":")
        if equals and not (start and end):
            raise InputError(f"--delay {text}: write FROM:TO=TICKS, for example sensors:controller=5, or TICKS for all")
        count = _ticks(ticks, text)
        system = system.with_delay(start, end, count) if equals else system.with_every_delay(count)
    return system


def with_step_sizes(system: System, texts: Sequence[str]) -> System:
    """Return the system with step sizes given for all, by PATTERN= and by COMPONENT=; the later of these goes before.

    `load_system` has applied one for all already, but a system rebuilt from a checkpoint is without it.
    """
    from lockstep.system.name_patterns import is_pattern, named

    refuse_repeated(texts, "--step-size")
    if empty := next((text for text in texts if text.startswith("=")), None):
        raise InputError(f"--step-size {empty}: write COMPONENT=S, for example plant{empty}, or {empty[1:]} for all")
    sizes = [(name, size) for name, _, size in (text.rpartition("=") for text in texts)]
    for name, size in sorted(sizes, key=lambda entry: (entry[0] != "", not is_pattern(entry[0]))):
        for each in named(name or "*", [component.name for component in system.components]):
            system = system.with_period(each, _positive(size, f"--step-size {each}"))
    return system


def _positive(text: str, option: str) -> Time:
    from lockstep.system.clock import positive_nanoseconds

    return positive_nanoseconds(text, option)


def _ticks(text: str, given: str | None = None) -> int:
    if not (text.isascii() and text.isdecimal()):
        option = f"--delay {given or text}"
        raise InputError(f"{option}: write FROM:TO=TICKS, for example sensors:controller=5, or TICKS for all")
    return int(text)
