"""Prepare the animation of the structure: mesh, mode shapes and wheels, and modal coordinates and torques over time.

Where there is no room for every recorded row, motion is low-pass filtered before rows are left out, so that no fast
vibration appears as a slow one.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.signal import resample_poly

from flexbench.runs import histories
from flexbench.runs.flown_design import FlownDesign
from flexbench.runs.run_folder import Run
from flexsat.arrays import Array
from flexsat.description.configuration import Configuration
from flexsat.parameters import DEFAULT_DESIGN
from flexsat.spacecraft.assembly import build_spacecraft
from flexsat.spacecraft.flexible import structure_of
from lockstep import InputError, Signals

from .derived_histories import ERRORS, MODAL, design_of, fully_recorded
from .history_data import encode

FEWEST_FRAMES = 300


def geometry_data(run: Run) -> dict[str, Any]:
    """Return mesh, mode shapes and wheels of the spacecraft of a run that `motion_data` has frames of."""
    return _geometry(run.spacecraft.configurations[DEFAULT_DESIGN])


@lru_cache(maxsize=2)
def _geometry(config: Configuration) -> dict[str, Any]:
    structure = structure_of(config)
    mesh, craft = structure.mesh, build_spacecraft(config)
    if mesh is None:
        raise InputError("the animation is that of an aperture, and the spacecraft has none")
    wheels = replace(craft.wheels, position=craft.wheels.position + craft.centre)
    sites = [_node_at(mesh.nodes, position) for position in wheels.position]
    return {
        "nodes": encode(mesh.nodes.astype(np.float32)),
        "triangles": encode(mesh.triangles.astype(np.uint16)),
        "hole": [int(node) for node in mesh.hole],
        "shapes": encode(structure.deflection[: len(mesh.nodes), 2].astype(np.float32)),  # node by node
        "modes": len(structure.frequency),
        "wheels": [
            {"node": node, "axis": [float(x) for x in axis]} for node, axis in zip(sites, wheels.axis, strict=True)
        ],
        "torque_limit": float(config.wheel_set.torque_limit.max()),
    }


def has_known_shapes(run: Run, design: FlownDesign) -> bool:
    """Return whether the modes that flew are those of a described aperture, so that their shapes are known."""
    try:
        config = run.spacecraft.configurations[DEFAULT_DESIGN]
    except InputError:
        return False
    if config.aperture is None:
        return False
    stock = structure_of(config).frequency
    return design.modes <= len(stock) and bool(np.allclose(design.frequency, stock[: design.modes], rtol=1e-6))


def _node_at(nodes: Array, position: Array) -> int:
    """Return the mesh node of a device, or -1 for the bus, which does not deform."""
    distance = np.linalg.norm(nodes - position[:2], axis=1)
    nearest = int(np.argmin(distance))
    return nearest if distance[nearest] < 1e-3 else -1


def motion_data(signals: Signals, run: Run, budget: int) -> dict[str, Any] | None:
    """Return the frames of the animation within `budget` bytes; None if no modes were recorded.

    None too for a structure with other modes: their shapes are not known.

    Frames are the recorded rows if all fit. Otherwise they are motion below half the frame rate, with the modes below
    it; `band` is that frequency [Hz], and `share` how much of the RMS deformation they show. Modal coordinates and
    torques are 16- and 8-bit fractions of their largest values.
    """
    design = design_of(run)
    if design is None or len(signals.time) < 2 or not fully_recorded(signals, design, MODAL):
        return None
    if not has_known_shapes(run, design):
        return None
    modal = signals[MODAL]
    torque = np.zeros((len(modal), 0))
    if fully_recorded(signals, design, histories.TORQUE):
        torque = signals[histories.TORQUE]
    step = float(signals.time[-1] - signals.time[0]) / (len(signals.time) - 1)
    frequency = np.full(modal.shape[1], np.inf)  # Hz, ascending; a variant may lack the modes of the last ports
    frequency[: design.modes] = design.frequency / (2.0 * np.pi)
    stride = _stride(frequency, step, len(modal), budget, torque.shape[1])
    error = histories.pointing_error_vector(signals) if fully_recorded(signals, design, *ERRORS) else None
    band: dict[str, Any] = {}
    if stride > 1:
        nyquist = 0.5 / (stride * step)
        every = float(np.einsum("ij,ij", modal, modal)) / len(modal)
        modal, torque = _below(modal[:, frequency < nyquist], stride), _below(torque, stride)
        error = None if error is None else _below(error, stride)
        shown = float(np.sum(modal**2)) / len(modal)
        band = {"band": nyquist, "share": math.sqrt(shown / every) if every > 0.0 else 1.0}
    scale = np.maximum(np.abs(modal).max(axis=0), np.finfo(float).tiny)
    largest = max(float(np.abs(torque).max(initial=0.0)), np.finfo(float).tiny)
    frames_data: dict[str, Any] = {
        "configuration": run.configuration,
        "frames": len(modal),
        "start": float(signals.time[0]),
        "step": stride * step,
        "modes": modal.shape[1],
        "modal": encode(np.round(modal / scale * 32767.0).astype(np.int16)),
        "scale": [float(x) / 32767.0 for x in scale],
        "torque": encode(np.round(torque / largest * 127.0).astype(np.int8)),
        "largest_torque": largest,
        "wheels": torque.shape[1],
    } | band
    if error is not None:
        frames_data["error"] = encode(error.astype(np.float32))
    return frames_data


def _stride(frequency: Array, step: float, rows: int, budget: int, wheels: int) -> int:
    """Return the least number of rows between frames whose modes, torques and error vector fit `budget` bytes."""
    stride = 1
    while True:
        frames = math.ceil(rows / stride)
        modes = len(frequency) if stride == 1 else int(np.count_nonzero(frequency < 0.5 / (stride * step)))
        if frames * (2 * modes + wheels + 3 * 4) <= budget or frames <= FEWEST_FRAMES:
            return stride
        stride += 1


def _below(values: Array, stride: int) -> Array:
    """Return every `stride`-th row of values without what is faster than half of that rate; no delay."""
    if values.shape[1] == 0:
        return values[::stride]
    return np.asarray(resample_poly(values, 1, stride, axis=0, padtype="line"))
