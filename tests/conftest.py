"""One BLAS thread a process, before numpy is imported: the tests run side by side, and the matrices are small."""

import os

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")
