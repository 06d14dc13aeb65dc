"""Sine and cosine from sums and products alone, so that host, board and Python agree to the last bit.

Every C library has its own `sin`: newlib's for Cortex-M holds fused multiply-adds, glibc's picks its code by the
processor. Here the angle is brought to |y| <= pi/4 by five parts of pi/2. The first three have at most 11 bits: n
times them is exact, in single precision too, and so are the differences in doubles; the fourth has 36 bits, and only
its difference rounds; the fifth counts next to a zero. The series of Taylor follow, up to y^17 and y^16, whose first
terms left out are 1e-19 and 2e-18. Up to `LARGEST` the error is below 1.5 units in the last place in double and below
two in single precision. Importing this module loads numba.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import compiled

LARGEST = 100.0  # rad; no shoulder turns so far, and beyond some 1e4 the parts would not be exact
PER_RIGHT = 2.0 / math.pi
RIGHT_0, RIGHT_1, RIGHT_2 = 1.5703125, 4.8351287841796875e-4, 3.1385570764541626e-07
RIGHT_3, RIGHT_4 = 6.077100506473373e-11, 3.2820035428735005e-22
# 1 / n!, the signs stand in the sums
F3, F5, F7, F9, F11, F13, F15, F17 = (1.0 / math.factorial(n) for n in range(3, 18, 2))
F4, F6, F8, F10, F12, F14, F16 = (1.0 / math.factorial(n) for n in range(4, 17, 2))


@compiled
def sincos(angle):
    """Sine and cosine.

    Args:
        angle: rad.

    Returns:
        Both; NaN where the angle is no number or beyond `LARGEST`.
    """
    if not abs(angle) <= LARGEST:
        return math.nan, math.nan
    n = float(math.floor(angle * PER_RIGHT + 0.5))
    y = ((((angle - n * RIGHT_0) - n * RIGHT_1) - n * RIGHT_2) - n * RIGHT_3) - n * RIGHT_4
    z = y * y
    tail = z * (F11 - z * (F13 - z * (F15 - z * F17)))
    s = y - y * z * (F3 - z * (F5 - z * (F7 - z * (F9 - tail))))
    tail = z * (F10 - z * (F12 - z * (F14 - z * F16)))
    half = 0.5 * z
    one = 1.0 - half
    c = one + (((1.0 - one) - half) + z * z * (F4 - z * (F6 - z * (F8 - tail))))
    quarter = n - 4.0 * float(math.floor(0.25 * n))  # exact, and cheaper on a core than a whole number
    if quarter == 1.0:  # exact: a whole number
        return c, -s
    if quarter == 2.0:  # exact: a whole number
        return -s, -c
    if quarter == 3.0:  # exact: a whole number
        return -c, s
    return s, c
