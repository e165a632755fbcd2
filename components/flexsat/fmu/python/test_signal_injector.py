"""Add a test signal to the signals between two components, to measure the response of a loop.

Not part of the spacecraft. It is connected between any controller and any plant, and repeats its waveform.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...ports.table import Port
from .life_cycle import ComponentSlave

WAVEFORM_FILE = "waveform.npz"  # arrays `waveform`, (k,), `channels`, `period` [s] and `unit`


@dataclass(slots=True)
class InjectorState:
    """Position in the waveform."""

    count: int


class Injector(ComponentSlave):
    """Add a periodic waveform along a direction to the signals that pass through."""

    description = "Adds a periodic test signal to the signals that pass through"

    def ports(self) -> Sequence[Port]:
        """Return the ports; size and unit are those in the resources."""
        with np.load(self.resource(WAVEFORM_FILE)) as archive:
            self._waveform = archive["waveform"]
            self.fixed_step = float(archive["period"])
            size, unit = int(archive["channels"]), str(archive["unit"])
        return (
            Port(name="signal", causality="input", unit=unit, size=size, description="what the producer gives"),
            Port(name="before", causality="output", unit=unit, size=size, variability="discrete",
                 depends_on=("signal[i]",), description="the same, as it came"),
            Port(name="after", causality="output", unit=unit, size=size, variability="discrete",
                 depends_on=("signal[i]",), description="with the test signal added: for the consumer"),
            Port(name="direction", causality="parameter", unit="1", size=size,
                 description="share of the test signal that is added to each signal"),
            Port(name="amplitude", causality="parameter", unit=unit, start=0.0,
                 description="what the waveform is multiplied with"),
        )  # fmt: skip

    def start(self) -> None:
        """Start at the first value of the waveform."""
        self._signal, self._before, self._after = (self.view(name) for name in ("signal", "before", "after"))
        self._direction = self.value("amplitude") * np.array(self.value("direction"))
        self.state = InjectorState(count=0)

    def advance(self, _time: float, _step: float, /) -> None:
        """Add this step's value; the outputs hold from now on."""
        state = self.state
        self._before[:] = self._signal
        np.add(self._signal, self._waveform[state.count % len(self._waveform)] * self._direction, out=self._after)
        state.count += 1
