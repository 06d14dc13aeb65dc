"""The faults: one a line or two of proofs and certificates, by the tests of the room that should catch them."""

from __future__ import annotations

MECHANISM, PROOF = "delta_cad/mechanism", "delta_cad/mechanism/proof"
GLOBALOPT, CERTIFY = "optimizer/globalopt", "optimizer/certify"

MUTANTS: dict[str, tuple[tuple[str, str, str, str], ...]] = {
    PROOF: (
        ("affine_form", "a product forgets its rounding", "+ ROUND * (ma * mb) + TINY", "+ TINY"),
        ("affine_form", "a product forgets a mixed term", "abs(a[2] * b[3] + a[3] * b[2])", "0.0"),
        ("enclosure", "kappa forgets the smallest eigenvalue's bound", "(k[10] + k[11]) * below", "0.0 * below"),
        ("prove", "a point refutes that may break a limit", "table[bit, HIGH] < 0.0", "table[bit, LOW] < 0.0"),
        (
            "prove",
            "half of the half cube is searched",
            "side, cube.half_side, cube",
            "side, 0.5 * cube.half_side, cube",
        ),
        ("prove", "a halved box leaves its upper half out", "cell[2 * axis + 1] += 1", "cell[2 * axis + 1] += 0"),
    ),
    MECHANISM: (("workspace", "the cube is sampled to half its height", "+ 2.0 * self.half_side", "+ self.half_side"),),
    GLOBALOPT: (
        ("branch_and_bound", "a contraction is rounded inwards", "(left - PAD) - error", "(left + PAD) + error"),
        ("affine_form", "a product forgets a mixed term", "abs(a[3] * b[4] + a[4] * b[3])", "0.0"),
        ("cutting_points", "a row forgets its error", "f * form[4], f * form[5]", "f * form[4], 0.0"),
        ("dual_simplex", "a sum of rows forgets its rounding", "top + 2.0 * ROUND * (total + e) <", "top <"),
        ("design_box", "the space is rounded inwards", "np.array(low) - sizes", "np.array(low) + sizes"),
        ("design_box", "the outline is rounded down", "total + OUTWARDS * abs(reach)", "total - OUTWARDS * abs(reach)"),
    ),
    CERTIFY: (
        ("tiling", "a box beside the cube is a tile", "not 0 <= i < 2**k", "not 0 <= i <= 2**k"),
        ("interval", "an upper end is not moved outwards", "np.nextafter(hi, np.inf))", "hi)"),
        ("replay", "a chain takes its neighbour's forearms", "[i - 2], p.forearm[i - 1]", "[i - 1], p.forearm[i]"),
        ("replay", "rods lean to one side only", "for side in (1.0, -1.0)", "for side in (-1.0,)"),
        ("gravity", "the carried weight is dropped", "self.force + self.weight, math", "self.force, math"),
        ("gravity", "too small a reserve passes", "reserve**2 < Fraction(m.arm_moment) ** 2 * g2", "reserve < 0"),
    ),
}
"""Room -> (module, what is wrong, text that stands there exactly once, what replaces it)."""
