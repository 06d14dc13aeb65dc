"""Our sine and cosine against the series in decimals of sixty digits, and against single precision by NumPy."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from itertools import product

import numpy as np
import pytest

from haptics.control.sincos import LARGEST, sincos

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899")


def exact(angle: float) -> tuple[Decimal, Decimal]:
    """Sine and cosine to some fifty digits: the series after halving the angle, then doubled again."""
    with localcontext() as context:
        context.prec = 70
        y = Decimal(angle) % (2 * PI) / 256
        sine, cosine, term = Decimal(0), Decimal(0), Decimal(1)
        for n in range(60):
            if n % 2:
                sine += term if n % 4 == 1 else -term
            else:
                cosine += term if n % 4 == 0 else -term
            term *= y / (n + 1)
        for _ in range(8):
            sine, cosine = 2 * sine * cosine, cosine * cosine - sine * sine
        return sine, cosine


def units(found: float, true: Decimal, kind: type = np.float64) -> float:
    """Error in units of the last place of the true value."""
    return abs(float((Decimal(float(found)) - true) / Decimal(float(np.spacing(kind(abs(true)))))))


def angles(count: int) -> list[float]:
    """Random ones in the range of a shoulder and beyond, and the doubles next to multiples of an eighth of a turn."""
    rng = np.random.default_rng(5)
    known = [k * math.pi / 4.0 for k in range(-120, 121)]
    near = [float(np.nextafter(a, side)) for a, side in product(known, (-200.0, 200.0))]
    tiny = [0.0, -0.0, 5e-324, 1e-300, 1e-17, -1e-9, 1e-4]
    return [*rng.uniform(-1.6, 1.6, count), *rng.uniform(-LARGEST, LARGEST, count), *known, *near, *tiny]


def test_the_oracle_is_right() -> None:
    assert abs(exact(1.0)[0] - Decimal("0.84147098480789650665250232163029899962256306079837")) < Decimal("1e-48")
    assert abs(exact(1.0)[1] - Decimal("0.54030230586813971740093660744297660373231042061792")) < Decimal("1e-48")


def test_it_is_right_to_one_and_a_half_units_in_the_last_place() -> None:
    worst = max(max(map(units, sincos(angle), exact(angle))) for angle in angles(3000))
    assert 0.5 < worst < 1.5


def test_machine_code_and_python_agree_to_the_last_bit() -> None:
    for angle in angles(2000):
        assert np.array_equal(sincos(angle), sincos.py_func(angle))


def test_single_precision_is_right_to_two_units() -> None:
    worst = 0.0
    with np.errstate(under="ignore"):
        for angle in angles(500):
            single = np.float32(angle)
            found = sincos.py_func(single)
            if abs(single) > 1e-30:
                worst = max(worst, *(units(a, b, np.float32) for a, b in zip(found, exact(float(single)), strict=True)))
    assert 0.5 < worst < 2.0


@pytest.mark.parametrize("angle", [math.nan, math.inf, -math.inf, 1e300, np.nextafter(LARGEST, 200.0)])
def test_what_is_no_shoulder_angle_has_none(angle: float) -> None:
    assert np.isnan(sincos(angle)).all()
    assert np.isfinite(sincos(math.copysign(LARGEST, angle))).all()
