"""Write the modes of a NASTRAN run as plain arrays: a script for a Python that has pyNastran, and needs nothing else.

    python nastran_extract.py array.op2 array.bdf arrays.npz

pyNastran needs another numpy than flexsat, so that this file imports nothing of flexsat. Units are those of the model,
axes its basic coordinate system. Masses are lumped at nodes in equal parts, as NASTRAN does by default.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from pyNastran.bdf.bdf import BDF
from pyNastran.op2.op2 import OP2

GRID = 1  # kind of a point in a table of displacements
BASIC = ("BOUGV1", "BOPHIG")  # tables that are in the basic coordinate system already
WITHOUT_MASS = ("CELAS", "CBUSH", "CDAMP", "CVISC", "CGAP", "CFAST", "CWELD", "PLOTEL")


def extract(op2_path: Path, bdf_path: Path) -> dict[str, Any]:
    """Return the arrays of a run of SOL 103; SystemExit with one line for files that have no such modes."""
    model = BDF(debug=False, log=None)
    model.read_bdf(str(bdf_path), validate=False)
    results = OP2(debug=False, log=None)
    results.read_op2(str(op2_path))
    if len(results.eigenvectors) != 1 or len(results.eigenvalues) > 1:
        raise SystemExit(
            f"{op2_path.name}: eigenvectors of {len(results.eigenvectors)} subcases, and must be of one; run SOL 103"
            " with one subcase and DISPLACEMENT(PLOT) = ALL"
        )
    table = next(iter(results.eigenvectors.values()))
    rows = {int(node): k for k, (node, kind) in enumerate(table.node_gridtype) if kind == GRID}
    numbers = sorted(model.nodes)
    absent = [node for node in numbers if node not in rows]
    if absent:
        raise SystemExit(
            f"{op2_path.name}: no shapes of {len(absent)} nodes of {bdf_path.name}, the first {absent[0]}; take both of"
            " one run, with DISPLACEMENT(PLOT) = ALL"
        )
    position = np.array([model.nodes[node].get_position() for node in numbers])
    shape = np.array(table.data[:, [rows[node] for node in numbers]], np.float64)  # (m, n, 6)
    if table.table_name not in BASIC:
        for k, node in enumerate(numbers):
            axes = axes_at(model.nodes[node].cd_ref, position[k])
            shape[:, k, :3], shape[:, k, 3:] = shape[:, k, :3] @ axes, shape[:, k, 3:] @ axes
    lumped = Masses(numbers, position, shape)
    for element in [*model.elements.values(), *model.masses.values()]:
        lumped.add(element)
    weight = float(model.params["WTMASS"].values[0]) if "WTMASS" in model.params else 1.0
    found = {
        "frequency": np.asarray(table.mode_cycles, np.float64),
        "edges": np.array(sorted(edges(model, numbers)), np.int64).reshape(-1, 2),
        **lumped.arrays(weight),
    }
    for values in results.eigenvalues.values():  # without this table the shapes are taken as normalised by mass
        modes = np.asarray(table.modes) - 1
        found["frequency"] = np.asarray(values.cycles, np.float64)[modes]
        found["modal_mass"] = np.asarray(values.generalized_mass, np.float64)[modes]
    for point in results.grid_point_weight.values():
        if point.reference_point == 0:
            found["rigid_mass"] = weight * np.asarray(point.MO, np.float64)
    return found


def axes_at(system: Any, place: Any) -> Any:
    """Return the axes, as rows, in which a node at a place has its displacements."""
    axes = np.array(system.beta(), np.float64)
    kind = system.type[-1]
    if kind == "R" or system.cid == 0:
        return axes
    x, y, z = axes @ (place - system.origin)
    turn = np.arctan2(y, x)
    radial, around = np.array([np.cos(turn), np.sin(turn), 0.0]), np.array([-np.sin(turn), np.cos(turn), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    if kind == "C":
        return np.array([radial, around, up]) @ axes
    polar = np.arctan2(np.hypot(x, y), z)
    outward = np.sin(polar) * radial + np.cos(polar) * up
    down = np.cos(polar) * radial - np.sin(polar) * up
    return np.array([outward, down, around]) @ axes


class Masses:
    """Nodes with what is lumped at them; a mass beside its node becomes a node of its own, which moves rigidly."""

    def __init__(self, numbers: list[int], position: Any, shape: Any) -> None:
        """Take the nodes of the model, and their shapes, (m, n, 6)."""
        self.index = {node: k for k, node in enumerate(numbers)}
        self.names = [str(node) for node in numbers]
        self.position = list(position)
        self.shape = list(np.moveaxis(shape, 0, 2))  # of each node (6, m)
        self.mass = [0.0] * len(numbers)
        self.inertia = [np.zeros((3, 3)) for _ in numbers]

    def add(self, element: Any) -> None:
        """Count an element; SystemExit for one whose mass is not known."""
        if element.type.startswith(WITHOUT_MASS):
            return
        if element.type == "CONM2":
            self._add_at(self.index[element.nid], element)
            return
        if element.type.startswith(("CONM", "CMASS")):
            raise SystemExit(f"element {element.eid}, {element.type}: its mass is not read; write it as CONM2")
        nodes = [node for node in element.node_ids if node in self.index]
        mass = float(element.Mass())
        for node in nodes:
            self.mass[self.index[node]] += mass / len(nodes)
        if element.type == "CBEAM" and mass:
            ends = [self.position[self.index[node]] for node in nodes[:2]]
            along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
            polar = mass / element.Area() * (element.I11() + element.I22())
            for node in nodes[:2]:
                self.inertia[self.index[node]] += 0.5 * polar * np.outer(along, along)

    def _add_at(self, at: int, element: Any) -> None:
        basic = element.cid in (0, -1)
        axes = np.eye(3) if basic else np.asarray(element.cid_ref.beta(), np.float64)
        place = np.asarray(element.X, np.float64)
        if element.cid != -1:
            place = self.position[at] + place @ axes
        offset = place - self.position[at]
        if np.linalg.norm(offset) > 0.0:
            moved = self.shape[at].copy()
            moved[:3] += np.cross(self.shape[at][3:].T, offset).T
            self.names.append(f"{self.names[at]}.{element.eid}")
            self.position.append(place)
            self.shape.append(moved)
            self.mass.append(0.0)
            self.inertia.append(np.zeros((3, 3)))
            at = len(self.names) - 1
        self.mass[at] += float(element.mass)
        xx, xy, yy, xz, yz, zz = element.I
        own = np.array([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]], np.float64)
        self.inertia[at] = self.inertia[at] + axes.T @ own @ axes

    def arrays(self, weight: float) -> dict[str, Any]:
        """Return nodes, shapes and masses, times the parameter WTMASS."""
        shape = np.array(self.shape)
        return {
            "node_name": np.array(self.names),
            "node_position": np.array(self.position),
            "node_translation": shape[:, :3],
            "node_rotation": shape[:, 3:],
            "node_mass": weight * np.array(self.mass),
            "node_inertia": weight * np.array(self.inertia),
        }


def edges(model: Any, numbers: list[int]) -> set[tuple[int, int]]:
    """Return pairs of nodes, counted from 0, that elements join: for drawings."""
    index = {node: k for k, node in enumerate(numbers)}
    found = set()
    for element in model.elements.values():
        for pair in element.get_edge_ids() if hasattr(element, "get_edge_ids") else ():
            if all(node in index for node in pair):
                one, other = sorted(index[node] for node in pair)
                found.add((one, other))
    return found


if __name__ == "__main__":
    np.savez(sys.argv[3], **extract(Path(sys.argv[1]), Path(sys.argv[2])))
