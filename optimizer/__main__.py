"""`python -m optimizer`, with one thread for linear algebra: the last digits do not depend on the machine's cores."""

import os
import sys

from optimizer.cli import main

if __name__ == "__main__":
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")  # NumPy, whose matrices are of a few rows here, loads later
    sys.exit(main())
