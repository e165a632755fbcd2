"""Write results of SOL 103 with pyNastran's writer: a script for the Python that has it.

    python nastran_results.py arrays.npz array.op2

The arrays are `node` (n,), `shape` (m, n, 6), `frequency` (m,). The writer leaves the table of eigenvalues
out: shapes are normalised by mass.
"""

import sys

import numpy as np
from pyNastran.op2.op2 import OP2
from pyNastran.op2.op2_interface.op2_classes import RealEigenvectorArray

GRID = 1  # kind of a point
EIGENVECTORS = 7  # kind of a table; the writer has that of displacements
given = np.load(sys.argv[1])
count = len(given["frequency"])
omega = 2.0 * np.pi * given["frequency"]
number = np.arange(1, count + 1, dtype=np.int32)
points = np.column_stack([given["node"], np.full(len(given["node"]), GRID)]).astype(np.int32)
results = OP2(debug=False, log=None)
results.set_as_msc()
table = RealEigenvectorArray.add_modal_case(
    "OUGV1", points, given["shape"].astype(np.float32), 1, number, (omega**2).astype(np.float32),
    given["frequency"].astype(np.float32),
)  # fmt: skip
table.table_code = table.data_code["table_code"] = EIGENVECTORS
results.eigenvectors[1] = table
results.write_op2(sys.argv[2], nastran_format="msc")
