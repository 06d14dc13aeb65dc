"""The operations of `affine_form` on forms with seven symbols, and compiled functions of four made ones of seven.

A placed design has three variables more than a three-fold symmetric one, and forms over a box of them three slopes
more: nine doubles (c, s1 .. s7, e). The functions of the mechanism that read and fill forms stay as they are written:
`of_seven` makes a second function of each, which names the operations here in the place of those there.
"""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any

from delta_cad.common.jit import Compiled, compiled, renamed
from delta_cad.mechanism.enclosure import affine_form
from delta_cad.mechanism.enclosure.affine_form import ROUND, TINY

SYMBOLS = 7
TERMS = SYMBOLS + 2
# As `affine_form.UP`: an error term is here a sum of at most 40 products.
UP = 1.0 + 2.0**-46


@compiled
def constant(value, error):
    """As `affine_form.constant`."""
    return (value, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, error)


@compiled
def at(forms, i):
    """As `affine_form.at`, of (n, 9)."""
    s1, s2, s3, s4 = forms[i, 1], forms[i, 2], forms[i, 3], forms[i, 4]
    return (forms[i, 0], s1, s2, s3, s4, forms[i, 5], forms[i, 6], forms[i, 7], forms[i, 8])


@compiled
def put(forms, i, a):
    """As `affine_form.put`, of (n, 9)."""
    for k in range(TERMS):
        forms[i, k] = a[k]


@compiled
def slope(a):
    """As `affine_form.slope`."""
    return (((abs(a[1]) + abs(a[2])) + (abs(a[3]) + abs(a[4]))) + ((abs(a[5]) + abs(a[6])) + abs(a[7]))) * UP


@compiled
def lower(a):
    """As `affine_form.lower`."""
    r = slope(a) + a[8]
    return (a[0] - r) - ROUND * (abs(a[0]) + r)


@compiled
def upper(a):
    """As `affine_form.upper`."""
    r = slope(a) + a[8]
    return (a[0] + r) + ROUND * (abs(a[0]) + r)


@compiled
def magnitude(a):
    """As `affine_form.magnitude`."""
    return (abs(a[0]) + slope(a) + a[8]) * UP


@compiled
def _sized(c, s1, s2, s3, s4, s5, s6, s7, e):
    """A form whose numbers are rounded, its error by that, too."""
    size = ((abs(c) + abs(s1)) + (abs(s2) + abs(s3))) + ((abs(s4) + abs(s5)) + (abs(s6) + abs(s7)))
    return (c, s1, s2, s3, s4, s5, s6, s7, (e + ROUND * size + TINY) * UP)


@compiled
def add(a, b):
    """As `affine_form.add`."""
    c, s1, s2, s3 = a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]
    return _sized(c, s1, s2, s3, a[4] + b[4], a[5] + b[5], a[6] + b[6], a[7] + b[7], a[8] + b[8])


@compiled
def negative(a):
    """As `affine_form.negative`."""
    return (-a[0], -a[1], -a[2], -a[3], -a[4], -a[5], -a[6], -a[7], a[8])


@compiled
def subtract(a, b):
    """As `affine_form.subtract`."""
    return add(a, negative(b))


@compiled
def scale(k, a):
    """As `affine_form.scale`."""
    return _sized(k * a[0], k * a[1], k * a[2], k * a[3], k * a[4], k * a[5], k * a[6], k * a[7], abs(k) * a[8])


@compiled
def multiply(a, b):
    """As `affine_form.multiply`; the error is a sum of some 35 products.

    Each of the products of (|c| + |s1| + ..) is rounded at most 7 times on its way into a number.
    """
    q1 = 0.5 * (a[1] * b[1])
    q2 = 0.5 * (a[2] * b[2])
    q3 = 0.5 * (a[3] * b[3])
    q4 = 0.5 * (a[4] * b[4])
    q5 = 0.5 * (a[5] * b[5])
    q6 = 0.5 * (a[6] * b[6])
    q7 = 0.5 * (a[7] * b[7])
    c = a[0] * b[0] + (((q1 + q2) + (q3 + q4)) + ((q5 + q6) + q7))
    bent = ((abs(q1) + abs(q2)) + (abs(q3) + abs(q4))) + ((abs(q5) + abs(q6)) + abs(q7))
    bent += abs(a[1] * b[2] + a[2] * b[1]) + abs(a[1] * b[3] + a[3] * b[1])
    bent += abs(a[1] * b[4] + a[4] * b[1]) + abs(a[1] * b[5] + a[5] * b[1])
    bent += abs(a[1] * b[6] + a[6] * b[1]) + abs(a[1] * b[7] + a[7] * b[1])
    bent += abs(a[2] * b[3] + a[3] * b[2]) + abs(a[2] * b[4] + a[4] * b[2])
    bent += abs(a[2] * b[5] + a[5] * b[2]) + abs(a[2] * b[6] + a[6] * b[2])
    bent += abs(a[2] * b[7] + a[7] * b[2])
    bent += abs(a[3] * b[4] + a[4] * b[3]) + abs(a[3] * b[5] + a[5] * b[3])
    bent += abs(a[3] * b[6] + a[6] * b[3]) + abs(a[3] * b[7] + a[7] * b[3])
    bent += abs(a[4] * b[5] + a[5] * b[4]) + abs(a[4] * b[6] + a[6] * b[4])
    bent += abs(a[4] * b[7] + a[7] * b[4])
    bent += abs(a[5] * b[6] + a[6] * b[5]) + abs(a[5] * b[7] + a[7] * b[5])
    bent += abs(a[6] * b[7] + a[7] * b[6])
    ma, mb = abs(a[0]) + slope(a), abs(b[0]) + slope(b)
    e = bent + (ma * b[8] + mb * a[8] + a[8] * b[8]) + ROUND * (ma * mb) + TINY
    return (
        c,
        a[0] * b[1] + b[0] * a[1],
        a[0] * b[2] + b[0] * a[2],
        a[0] * b[3] + b[0] * a[3],
        a[0] * b[4] + b[0] * a[4],
        a[0] * b[5] + b[0] * a[5],
        a[0] * b[6] + b[0] * a[6],
        a[0] * b[7] + b[0] * a[7],
        e * UP,
    )


@compiled
def _linear(a, k, low, high, pad):
    """As `affine_form._linear`."""
    middle = 0.5 * (low + high)
    e = abs(k) * a[8] + 0.5 * (high - low) + pad + ROUND * (abs(k * a[0]) + abs(middle))
    return _sized(k * a[0] + middle, k * a[1], k * a[2], k * a[3], k * a[4], k * a[5], k * a[6], k * a[7], e)


@compiled
def _nothing():
    """A form that says nothing."""
    return (math.nan, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, math.inf)


@compiled
def root(a):
    """As `affine_form.root`."""
    lo = lower(a)
    if not lo > 0.0:
        return _nothing()
    return _root(a, lo, upper(a))


@compiled
def inverse(a):
    """As `affine_form.inverse`."""
    lo = lower(a)
    if not lo > 0.0:
        return _nothing()
    return _inverse(a, lo, upper(a))


_SUMS = (constant, at, put, slope, lower, upper, magnitude, add, negative, subtract)
_OWN = (*_SUMS, scale, multiply, _linear, root, inverse)
_MADE: dict[Compiled, Compiled] = {getattr(affine_form, one.__name__): one for one in _OWN}
_NUMBERS: dict[str, Any] = {"SYMBOLS": SYMBOLS, "TERMS": TERMS, "UP": UP}
_MODULES: dict[str, ModuleType] = {}


def stands_for(function: Compiled, own: Compiled) -> None:
    """Notes a function that stands for one of four symbols wherever that is called."""
    _MADE[function] = own


def own(function: Compiled) -> None:
    """Notes a function that is written for seven symbols."""
    _MADE[function] = function


def number(name: str, value: Any) -> None:
    """Notes what a global number is where there are seven symbols."""
    _NUMBERS[name] = value


def of_seven(function: Compiled) -> Compiled:
    """Makes the function of forms with seven symbols of one of four; of one that is known, that."""
    if function not in _MADE:
        _MADE[function] = renamed(function, _seven, "of_seven")
    return _MADE[function]


def _seven(name: str, value: Any) -> Any:
    if isinstance(value, Compiled):
        return of_seven(value)
    if name in _NUMBERS and isinstance(value, int | float | tuple):
        return _NUMBERS[name]
    if isinstance(value, ModuleType) and value.__name__.startswith("delta_cad."):
        return _module(value)
    return value


def _module(module: ModuleType) -> ModuleType:
    """Makes a module with the same numbers and functions of seven."""
    if module.__name__ not in _MODULES:
        made = ModuleType(f"{module.__name__}_of_seven")
        _MODULES[module.__name__] = made
        for name, value in vars(module).items():
            if not name.startswith("__") and (isinstance(value, int | float | Compiled)):
                setattr(made, name, _seven(name, value))
    return _MODULES[module.__name__]


_root, _inverse = of_seven(affine_form._root), of_seven(affine_form._inverse)
