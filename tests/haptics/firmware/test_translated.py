"""Small functions in C against themselves in Python: every operator, number for number."""

from __future__ import annotations

import ctypes
import math
import subprocess
from pathlib import Path

import numpy as np
from numba import float64, int64, typeof

from delta_cad.common.jit import compiled
from haptics.firmware.layout import prelude
from haptics.firmware.precision import DOUBLE
from haptics.firmware.translate import Translation
from tests.haptics.firmware.rig import FLAGS, tool

PLACES = 12


@compiled
def _inner(a, b):
    return a - 2.0 * b, a * b


@compiled
def _everything(a, b, k, out):
    out[0] = a / b - b * a
    out[1] = a**3 + b**2
    out[2] = min(a, b, 0.25) - max(a, -b)
    out[3] = 1.0 if (a < b and b > 0.0) or a > 0.9 else -1.0
    out[4] = abs(a - b) + math.floor(3.0 * a)
    out[5] = (k + 3) // 2 - k % 3
    out[6] = k / 4
    out[7] = 1.0 if not 0.1 < a <= 0.8 else 2.0
    first, second = _inner(a, b)
    out[8] = first - 3.0 * second
    total = 0.0
    for i in range(k):
        if i == 2:
            continue
        total += (i + 1) * a
        if total > 2.0:
            break
    out[9] = total
    bits = k | 8
    out[10] = (bits & 5) + (bits ^ 3) + (1 << k)
    out[11] = -a if math.isfinite(a / (b - b)) else a
    return math.sqrt(abs(a)) + float(math.floor(b))


def test_each_operator_is_python_s_own(tmp_path: Path) -> None:
    translation = Translation(DOUBLE)
    name, _ = translation.add(_everything, (float64, float64, int64, typeof(np.zeros(PLACES))))
    functions = "\n".join(translation.functions.values())
    call = (
        "double run(double a, double b, long long k, double *out)\n"
        f"{{\n    row to = {{ out, {PLACES} }};\n    return {name}(a, b, k, to);\n}}"
    )
    head = "#include <math.h>\n#include <stdlib.h>\ntypedef double delta_real;\n"
    structs = "\n".join(translation.structs.values())
    (tmp_path / "run.c").write_text("\n".join([head, prelude(DOUBLE, functions), structs, functions, call, ""]))
    command = [tool("gcc"), *FLAGS, "-fPIC", "-shared", str(tmp_path / "run.c"), "-o", str(tmp_path / "run.so"), "-lm"]
    subprocess.run(command, check=True)
    run = ctypes.CDLL(str(tmp_path / "run.so")).run
    run.restype, run.argtypes = ctypes.c_double, [ctypes.c_double, ctypes.c_double, ctypes.c_longlong, ctypes.c_void_p]
    rng = np.random.default_rng(3)
    for a, b, k in zip(rng.uniform(-1.0, 1.0, 300), rng.uniform(-1.0, 1.0, 300), rng.integers(0, 6, 300), strict=True):
        out = np.zeros(PLACES)
        reported = run(a, b, int(k), out.ctypes.data)
        with np.errstate(divide="ignore"):
            expected = np.zeros(PLACES)
            assert reported == _everything.py_func(np.float64(a), np.float64(b), int(k), expected)
        np.testing.assert_allclose(out, expected, rtol=0, atol=3e-16)  # a cube is a product here, a power there
