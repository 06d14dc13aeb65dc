"""No term of a product of affine forms is missing."""

from __future__ import annotations

from delta_cad.mechanism.proof.affine_form import multiply
from tests.affine_products import missed_products


def test_every_pair_of_symbols_is_counted() -> None:
    assert list(missed_products(multiply, 3)) == []
