"""No term of a product of affine forms is missing: two symbols at a time, where no other term's slack hides it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations_with_replacement, product

from delta_cad.mechanism.enclosure.affine_form import SYMBOLS, multiply

Form = tuple[float, ...]


def missed_products() -> Iterator[tuple[Form, Form, float]]:
    """Pairs of forms and a value of their product that the result does not contain; all numbers are exact doubles."""
    for j, k in combinations_with_replacement(range(SYMBOLS + 1), 2):  # the last stands for the form's own error
        for s, t, middle in product((-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0), (0.0, 0.5)):
            a, b = [middle] + [0.0] * (SYMBOLS + 1), [0.25] + [0.0] * (SYMBOLS + 1)
            a[1 + j], b[1 + j] = 1.0, abs(t) if j == SYMBOLS else t
            a[1 + k], b[1 + k] = abs(s) if k == SYMBOLS else s, 1.0
            c, *slopes, e = multiply(tuple(a), tuple(b))
            for u in product((-1.0, 0.0, 1.0), repeat=2):
                places = [0.0] * (SYMBOLS + 1)
                places[j], places[k] = u[0], u[1]
                linear = c + sum(x * y for x, y in zip(slopes, places, strict=False))
                left = sum((x * y for x, y in zip(a[1:], places, strict=True)), a[0])
                for other in (-1.0, 1.0):  # each form has an error of its own
                    right = sum((x * y for x, y in zip(b[1:-1], places, strict=False)), b[0]) + b[-1] * other
                    if abs(left * right - linear) > e:
                        yield tuple(a), tuple(b), left * right


def test_every_pair_of_symbols_is_counted() -> None:
    assert list(missed_products()) == []
