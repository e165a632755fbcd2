"""A spacecraft of five wheels whose arrays turn: off balance, with a wheel, gyros and accelerometers on one of them."""

from pathlib import Path

import numpy as np

from flexsat.description.spacecraft_file import parse_spacecraft
from flexsat.spacecraft.assembly import Spacecraft, build_spacecraft
from flexsat.structure.modal_data import ModalData
from flexsat.structure.modal_file import write_modal

TEXT = """\
name = "turning"
wheels = [{{ at = "bus", axes = ["+x", "+y", "+z", [1, 2, -1]] }}, {{ at = "tip", axes = [[1, 0, 2]] }}]
gyros = [{{ at = "bus", axes = ["+x", "+y"] }}, {{ at = "tip", axes = ["+z", [1, 1, 0]] }}]
accelerometers = [{{ at = "tip", axes = ["+x"] }}, {{ at = "bus", axes = ["+y"] }}, {{ at = "south", axes = ["+z"] }}]
[sites]
tip = {{ node = "north.tip" }}
south = {{ node = "south.middle" }}
[bus]
mass = 300
inertia = [120, 90, 100, 5, -4, 3]
centre_of_mass = [0.05, -0.1, 0.2]
[wheel]
inertia = 0.3
torque_limit = 0.5
[[appendages]]
name = "north"
file = "array.npz"
at = [0.1, 1, 0.3]
orientation = ["0 deg", "10 deg", "90 deg"]
axis = "+x"
angle = "{north} deg"
turns = true
[[appendages]]
name = "mast"
file = "array.npz"
at = [0, 0, 1]
orientation = [0, "-90 deg", 0]
damping_ratio = 0.01
modes = 2
[[appendages]]
name = "south"
file = "array.npz"
at = [0, -1, 0]
orientation = [0, 0, "-90 deg"]
axis = [1, 0, 0.2]
angle = "{south} deg"
turns = true
[modes]
plant = {modes}
design = 3
"""


def array() -> ModalData:
    """Return two masses off the drive's axis that move across it and turn: four modes."""
    random = np.random.default_rng(6)
    place = np.array([[2.0, 0.3, 0.1], [4.0, -0.2, 0.3]])
    mass = np.array([8.0, 5.0])
    # mass-normalised shapes, orthogonal in the masses
    basis = np.linalg.qr(random.standard_normal((6, 4)))[0].reshape(2, 3, 4)
    return ModalData(
        kind="clamped",
        frequency=np.array([0.4, 0.7, 1.1, 2.0]),
        damping_ratio=np.full(4, 0.004),
        node_name=("middle", "tip"),
        node_position=place,
        node_translation=basis / np.sqrt(mass)[:, None, None],
        node_rotation=0.2 * random.standard_normal((2, 3, 4)),
        node_mass=mass,
    )


def write_files(folder: Path, north: float = 25.0, south: float = -15.0, modes: int = 10) -> Path:
    """Write the spacecraft's file and its modal file with the arrays at angles [deg]; return the file."""
    write_modal(folder / "array.npz", array())
    path = folder / "turning.toml"
    path.write_text(TEXT.format(north=north, south=south, modes=modes), encoding="utf-8")
    return path


def spacecraft(folder: Path, north: float = 25.0, south: float = -15.0, modes: int = 10) -> Spacecraft:
    """Return the spacecraft with its arrays at angles [deg]."""
    text = write_files(folder, north, south, modes).read_text(encoding="utf-8")
    return build_spacecraft(parse_spacecraft(text, "turning.toml", folder).configurations["robust"])
