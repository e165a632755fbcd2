"""Captions of figures by the names of their files."""

from __future__ import annotations

import re

_CAPTIONS = {  # pattern of a file's name without its ending: caption
    r"structure": "The structure: tiles, mesh, and where wheels and sensors are, in both layouts.",
    r"mode-shapes.*": "Shapes and frequencies of the lowest modes, clamped at the bus.",
    r"campbell.*": (
        "Campbell diagram: frequencies of the modes over wheel speed, the harmonic of the imbalance, and the chosen "
        "speeds with their bands."
    ),
    r"wheel-responses-(?P<layout>[\w-]+?)(-as-published)?": (
        "Response of the structure to the imbalance of each wheel over its speed ({layout}); the nominal speed has "
        "the smallest maximum of the response over its band."
    ),
    r"software": "The software: packages, what each makes, and the files that pass between them.",
    r"architecture-(?P<layout>[\w-]+)": "The closed loop ({layout}): components, rates, and what they exchange.",
    r"slew(?P<variant>-as-published)?-seed(?P<seed>\d+)(-\d+)?": (
        "The slew{variant}, seed {seed}: torque of the wheels, cost, wheel speeds with their band, rotation, pointing "
        "and rate error, deformation; published values as diamonds."
    ),
    r"fine-pointing(?P<variant>-as-published)?-seed(?P<seed>\d+)(-\d+)?": (
        "Fine pointing{variant}, seed {seed}: pointing error and deformation over the whole run and its end."
    ),
    r"bandwidth-(?P<layout>[\w-]+)": (
        "Controller bandwidth over the wheel responses ({layout}): above, the response of the structure to each "
        "wheel's imbalance, coloured by its axis, and the chosen speeds; below, the gain of each body axis' loop. "
        "Shaded, if a gain is 1 in this range: up to the last frequency with a gain of 1. Above it the chosen speeds "
        "limit the response, not the controller."
    ),
    r"nichols-(?P<layout>[\w-]+)": (
        "Margins ({layout}): the open loop at the plant's input in a Nichols chart and near the critical point; the "
        "loci of all wheels nearest to it, and each body axis. Dashed: the largest disk around it that they avoid."
    ),
    r"sensitivity-(?P<layout>[\w-]+)": (
        "Margins ({layout}): largest singular values of sensitivity S and complementary sensitivity T over frequency, "
        "all wheels together; a high peak is a small margin."
    ),
    r"spillover-(?P<layout>[\w-]+)": (
        "Spillover ({layout}): stability of the loop over the number of modes of the plant and the gain of its inputs, "
        "for each design. A design spills over where modes outside its model make the loop unstable."
    ),
    r"robust-loop-shapes": (
        "Loop shapes: gain of each body axis' loop over frequency, robust and published design, with the modes outside "
        "the controller's model (spillover), and Nyquist diagrams near the critical point (margins)."
    ),
    r"robust-trade-off": (
        "Trade-offs of the robust design: pointing error over the tolerated delay, deformation over torque."
    ),
    r"profile": "Wall time of the run, by component.",
}


_ORDER = (  # of figures on a page: what flew, its loops, the spacecraft, the bench; what is not named here comes last
    *(r"slew-seed.*", r"fine-pointing-seed.*", r"slew-.*", r"fine-pointing-.*"),
    *("bandwidth-.*", "nichols-.*", "sensitivity-.*", "spillover-.*", "robust-.*"),
    *("structure", "mode-shapes.*", "campbell.*", "wheel-responses-.*", "architecture-.*", "software"),
)


def place_of(name: str) -> int:
    """Return where a figure stands on a page, by the name of its file."""
    return next((k for k, pattern in enumerate(_ORDER) if re.fullmatch(pattern, name)), len(_ORDER))


def caption_of(name: str) -> str:
    """Return the caption of a figure; for a name that is not known, the name in words."""
    for pattern, caption in _CAPTIONS.items():
        found = re.fullmatch(pattern, name)
        if found:
            words = {key: (value or "").replace("-", " ") for key, value in found.groupdict().items()}
            return caption.format(**words)
    return name.replace("-", " ").replace("_", " ")
