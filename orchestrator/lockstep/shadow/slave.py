"""Run two slaves as one: the original and its shadow get the same inputs, and the outputs of one of them act."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lockstep.arrays import refill
from lockstep.errors import InputError, RunError
from lockstep.fmi.slave import DTYPES, ERROR, FATAL, OK, SCALARS, WARNING, Buffer, Scalar, Slave, Stateful
from lockstep.shadow.ports import SHADOW, Joined, Match
from lockstep.shadow.values import Convert, OutputValues, conversion
from lockstep.system.clock import Time, common_divisor, read_nanoseconds, seconds, seconds_text, stored_nanoseconds
from lockstep.system.component import Shadow, Value

StatusCall = Callable[[], int]
AddEvent = Callable[..., None]
References = NDArray[np.uint32]
_PREFIX, _FILE = "shadow-", "shadow.npz"  # of the shadow's files in a saved state, and of this class's own


class ShadowedSlave:
    """Implement `lockstep.fmi.slave.Slave`. An error of the shadow is raised, under the shadow's name.

    After the switchover an error of the original is an event: it is not stepped any more, and its outputs stay.
    """

    def __init__(
        self, original: Slave, shadow: Slave, joined: Joined, plan: Shadow, first: Time, add_event: AddEvent
    ) -> None:
        """Bind the two; `first` [ns] is when their steps begin, `add_event` records an event."""
        self._original, self._shadow, self._joined, self._plan = original, shadow, joined, plan
        self._first, self._add_event = first, add_event
        self._step_length = common_divisor(plan.period, plan.component.period)
        self._switched = self._lost = False
        self._time = 0.0  # of the last step [s]
        self._alone = {match.shown.reference for match in joined.given if match.shown.name.startswith(SHADOW)}
        self._seen = {(match.shown.scalar, match.shown.reference): match for match in joined.seen}
        self._kept: dict[tuple[Scalar, bytes], Buffer] = {}  # what getters gave last
        self._original_step, self._shadow_step = original.do_step, shadow.do_step
        self._values = {scalar: OutputValues(scalar, joined, plan) for scalar in SCALARS}
        self._get_original: list[StatusCall] = []
        self._get_shadow: list[StatusCall] = []
        self._put_applied: list[Callable[[], object]] = []
        for scalar, values in self._values.items():
            if values.matches:
                references = _references(match.shown.reference for match in values.matches)
                self._get_original.append(original.getter(scalar, references, values.original))
                get = shadow.getter(scalar, _shadow_references(values.matches), values.raw)
                self._get_shadow.append(self._checked(f"Get{scalar}", get))
            applied = [match for match in joined.applied if match.shown.scalar == scalar]
            if applied:
                names = [match.shown.name for match in values.matches]
                positions = [names.index(match.shown.name) for match in applied]
                self._put_applied.append(values.update_applied)
                self._put_applied.append(self._to_shadow(scalar, applied, values.applied, positions))

    @property
    def do_step(self) -> Callable[[float, float, int], int]:
        """Step each of the two that is due, then select the outputs that act."""
        return self._step

    def _step(self, time: float, _step: float, new: int, /) -> int:
        self._time = time
        due, plan, status = self._since_first(time), self._plan, OK
        now = self._first + due
        shadow_due = due % plan.component.period == 0
        if shadow_due:  # first: in a process of its own it works while the original does
            for call in self._put_applied:
                call()
            self._check("DoStep", self._shadow_step(time, seconds(plan.component.period), new))
        if due % plan.period == 0 and not self._lost:
            status = self._step_original(time, now, new)
            if status > WARNING:
                return status
        if shadow_due:
            self._pull_shadow()
        if plan.switchover is not None and now >= plan.switchover and not self._switched:
            self._switch_over(now)
        for values in self._values.values():
            values.decide(now)
        return status

    def _since_first(self, time: float) -> Time:
        """Return how long the first step is ago [ns]: a whole number of steps, of which the nearest is the master's."""
        return round((time * 1e9 - float(self._first)) / float(self._step_length)) * self._step_length

    def _step_original(self, time: float, now: Time, new: int) -> int:
        over = self._plan.switchover
        replaced = over is not None and now > over
        try:
            status = self._original_step(time, seconds(self._plan.period), new)
            for get in self._get_original if status <= WARNING else ():
                status = max(status, get())
            reason = f"{self._original.outcome('DoStep', status)}: {self._original.last_messages()}"
        except RunError as error:
            if not replaced:
                raise
            status, reason = FATAL, str(error)
        if status > WARNING and replaced:
            self._original.failed(status)
            self._lost = True
            self._add_event("original-lost", name="original lost", reason=reason)
            return OK
        return status

    def _pull_shadow(self) -> None:
        for get in self._get_shadow:
            get()
        for values in self._values.values():
            values.pulled()

    def _switch_over(self, now: Time) -> None:
        self._switched = True
        reals = self._values["Real"]
        reals.keep_offset()
        self._add_event(
            "switchover",
            name="switchover",
            to=self._joined.name,
            at=seconds(now),
            blend=seconds(self._plan.blend),
            outputs=[match.shown.name for match in reals.matches],
            offset=reals.offset.tolist(),
            mean_offset=reals.mean.tolist(),
        )

    def getter(self, scalar: Scalar, references: References, buffer: Buffer) -> StatusCall:
        """Return a call that fills the buffer from the original, the shadow, and the values held here."""
        values, flat = self._values[scalar], self._values[scalar].flat
        taken = self._kept.setdefault((scalar, references.tobytes()), np.zeros(len(references), DTYPES[scalar]))
        numbers = references.tolist()
        here = [k for k, number in enumerate(numbers) if number in values.positions]
        of_shadow = [k for k, number in enumerate(numbers) if k not in here and (scalar, number) in self._seen]
        of_original = [k for k in range(len(numbers)) if k not in here and k not in of_shadow]
        calls: list[StatusCall] = []
        if of_original:
            part: Buffer = np.zeros(len(of_original), DTYPES[scalar])
            get_original = self._original.getter(scalar, references[of_original].copy(), part)
            calls.append(self._while_alive(_filled(get_original, part, taken, of_original)))
        if of_shadow:
            seen = [self._seen[scalar, numbers[k]] for k in of_shadow]
            raw: Buffer = np.zeros(len(of_shadow), DTYPES[scalar])
            get_shadow = self._shadow.getter(scalar, _shadow_references(seen), raw)
            get_shadow = self._checked(f"Get{scalar}", get_shadow)
            calls.append(_filled(get_shadow, raw, taken, of_shadow, conversion(seen)))
        targets, positions = (
            np.array(found, np.intp) for found in (here, [values.positions[numbers[k]] for k in here])
        )

        def get() -> int:
            status = OK
            for call in calls:
                status = max(status, call())
            taken[targets] = flat[positions]
            buffer[:] = taken
            return status

        return get

    def setter(self, scalar: Scalar, references: References, buffer: Buffer) -> StatusCall:
        """Return a call that sets the buffer on the original, and on the shadow what it has too."""
        numbers = references.tolist()
        calls: list[StatusCall] = []
        of_original = [k for k, number in enumerate(numbers) if number not in self._alone]
        if of_original:
            part: Buffer = np.zeros(len(of_original), DTYPES[scalar])
            put = self._original.setter(scalar, references[of_original].copy(), part)
            calls.append(self._while_alive(_sent(put, part, buffer, of_original)))
        pairs = [(k, m) for k, n in enumerate(numbers) for m in self._given(scalar) if m.shown.reference == n]
        if pairs:
            calls.append(self._to_shadow(scalar, [match for _, match in pairs], buffer, [k for k, _ in pairs]))

        def call() -> int:
            status = OK
            for each in calls:
                status = max(status, each())
            return status

        return call

    def _given(self, kind: Scalar) -> list[Match]:
        return [match for match in self._joined.given if match.shown.scalar == kind]

    def _to_shadow(
        self, scalar: Scalar, matches: Sequence[Match], source: Buffer, positions: Sequence[int]
    ) -> StatusCall:
        """Return a call that sets some values of a buffer on the shadow."""
        part: Buffer = np.zeros(len(matches), DTYPES[scalar])
        put = self._shadow.setter(scalar, _shadow_references(matches), part)
        return _sent(self._checked(f"Set{scalar}", put), part, source, positions, conversion(matches))

    def _while_alive(self, call: StatusCall) -> StatusCall:
        """Return a call that does nothing after the original is lost."""

        def checked() -> int:
            return OK if self._lost else call()

        return checked

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set parameters and start values: those of both on both, `shadow.X` on the shadow alone."""
        for_shadow: dict[int, Value] = {}
        for match in self._given(scalar):  # those of the shadow alone come last, and win
            if match.shown.reference in values:
                value = values[match.shown.reference]
                for_shadow[match.shadow.reference] = (
                    match.gain * float(value) + match.bias if scalar == "Real" else value
                )
        if for_shadow:
            self._check(f"Set{scalar}", self._shadow.set_start(for_shadow, scalar))
        for_original = {reference: value for reference, value in values.items() if reference not in self._alone}
        return self._original.set_start(for_original, scalar) if for_original else OK

    def setup_experiment(self, start: float, stop: float) -> int:
        """Announce the time span [s] to each, in whole steps of its own."""
        begin, end = self._since_first(start), self._since_first(stop)

        def last(period: Time) -> float:
            return seconds(self._first + begin - (begin - end) // period * period)

        self._check("SetupExperiment", self._shadow.setup_experiment(start, last(self._plan.component.period)))
        return self._original.setup_experiment(start, last(self._plan.period))

    def enter_initialization(self) -> int:
        """Enter initialization mode."""
        if self._joined.applied_valid is not None:
            self._check("SetBoolean", self._shadow.set_start({self._joined.applied_valid.reference: True}, "Boolean"))
        self._check("EnterInitializationMode", self._shadow.enter_initialization())
        return self._original.enter_initialization()

    def exit_initialization(self) -> int:
        """Leave initialization mode, and get the initial outputs."""
        self._check("ExitInitializationMode", self._shadow.exit_initialization())
        status = self._original.exit_initialization()
        for get in self._get_original if status <= WARNING else ():
            status = max(status, get())
        if status <= WARNING:
            self._pull_shadow()
            for values in self._values.values():
                values.acting[:] = values.original
        return status

    def _checked(self, function: str, call: StatusCall) -> StatusCall:
        """Return a call of the shadow whose failure is raised."""

        def checked() -> int:
            self._check(function, call())
            return OK

        return checked

    def _check(self, function: str, status: int) -> None:
        """Raise RunError if a call of the shadow failed."""
        if status > WARNING:
            self._shadow.failed(status)
            logged = self._shadow.last_messages()
            outcome = f"{self._joined.name}: {self._shadow.outcome(function, status)} at {self._time:.9g} s"
            raise RunError(outcome + (f": {logged}" if logged else ""))

    def save_state(self, folder: str) -> int:
        """Save the states of both and the values held here; RunError if the shadow cannot."""
        if self._lost or not isinstance(self._original, Stateful):
            return ERROR
        inner = Path(folder, "shadow")
        inner.mkdir()
        saved = self._shadow.save_state(str(inner)) if isinstance(self._shadow, Stateful) else ERROR
        self._check("GetFMUstate", saved)
        for file in inner.iterdir():
            file.rename(Path(folder, f"{_PREFIX}{file.name}"))
        inner.rmdir()
        over = self._plan.switchover if self._switched else None
        now = self._first + self._since_first(self._time)
        times = (now, -1 if over is None else over, self._plan.blend)
        done = np.array([str(stored_nanoseconds(time)) for time in times])
        arrays = [array for values in self._values.values() for array in values.memory()]
        np.savez(Path(folder, _FILE), done, *(a.astype(str) if a.dtype == object else a for a in arrays))
        return self._original.save_state(folder)

    def restore_state(self, folder: str) -> int:
        """Restore what `save_state` wrote; InputError if the switchover differs from the one that has happened."""
        if not isinstance(self._original, Stateful):
            return ERROR
        inner = Path(folder, "shadow")
        inner.mkdir()
        for file in Path(folder).glob(f"{_PREFIX}*"):
            file.rename(inner / file.name.removeprefix(_PREFIX))
        taken = self._shadow.restore_state(str(inner)) if isinstance(self._shadow, Stateful) else ERROR
        self._check("SetFMUstate", taken)
        with np.load(Path(folder, _FILE), allow_pickle=False) as saved:
            done, *arrays = (saved[name] for name in saved.files)
        memory = [array for values in self._values.values() for array in values.memory()]
        for array, content in zip(memory, arrays, strict=True):
            refill(array, content)
        self._resume(*(read_nanoseconds(time if "/" in str(time) else int(time), _FILE) for time in done.tolist()))
        return self._original.restore_state(folder)

    def _resume(self, now: Time, over: Time, blend: Time) -> None:
        """Continue the plan of a run at this time [ns]."""
        self._time, self._switched = seconds(now), over >= 0
        mine, name = self._plan.switchover, self._joined.name
        if over >= 0 and (over, blend) != (mine, self._plan.blend):
            options = f"--switchover {seconds_text(over)} --blend {seconds_text(blend)}"
            raise InputError(f"{name}: has acted since before the checkpoint; give {options} as in that run")
        if over < 0 and mine is not None and mine <= now:
            times = f"switchover {seconds_text(mine)} s: lies before the checkpoint, whose last step is"
            raise InputError(f"{times} {seconds_text(now)} s; choose a later one")

    def failed(self, status: int) -> None:
        """Note the status of the original that ended the run."""
        self._original.failed(status)

    def outcome(self, call: str, status: int) -> str:
        """Describe a failed call, as the original does."""
        return self._original.outcome(call, status)

    def last_messages(self) -> str:
        """Return what the original logged last, or nothing."""
        return self._original.last_messages()

    def close(self) -> None:
        """Terminate and free both."""
        self._original.close()
        self._shadow.close()


def _references(numbers: Iterable[int]) -> References:
    return np.fromiter(numbers, np.uint32)


def _shadow_references(matches: Sequence[Match]) -> References:
    return _references(match.shadow.reference for match in matches)


def _sent(
    put: StatusCall, part: Buffer, source: Buffer, positions: Sequence[int], convert: Convert | None = None
) -> StatusCall:
    """Return a call that selects values, converts them and sets them."""
    index = np.array(positions, np.intp)

    def call() -> int:
        part[:] = source[index] if convert is None else convert(source[index])
        return put()

    return call


def _filled(
    get: StatusCall, part: Buffer, target: Buffer, positions: Sequence[int], convert: Convert | None = None
) -> StatusCall:
    """Return a call that gets values, converts them and distributes them."""
    index = np.array(positions, np.intp)

    def call() -> int:
        status = get()
        target[index] = part if convert is None else convert(part)
        return status

    return call
