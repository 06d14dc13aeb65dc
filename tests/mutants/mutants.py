"""The faults: one a line of proofs and certificates, by the tests of the room that should catch them."""

from __future__ import annotations

ENCLOSURE, PROOF = "delta_cad/mechanism/enclosure", "delta_cad/mechanism/proof"
LIMITS = "delta_cad/mechanism/limits"
GLOBALOPT, CERTIFY = "optimizer/globalopt", "optimizer/certify"

# fmt: off
MUTANTS: dict[str, tuple[tuple[str, str, str, str], ...]] = {
    "tests/delta_cad/mechanism": (
        (f"{ENCLOSURE}/affine_form.py", "a product forgets its rounding", "+ ROUND * (ma * mb) + TINY", "+ TINY"),
        (f"{ENCLOSURE}/affine_form.py", "a product forgets a mixed term", "abs(a[3] * b[4] + a[4] * b[3])", "0.0"),
        (f"{ENCLOSURE}/interval.py", "an upper end is not moved outwards", "np.nextafter(hi, UP))", "hi)"),
        (f"{ENCLOSURE}/interval.py", "upper ends of many are not moved", "hi + (np.abs(hi) * UNIT + LEAST)", "hi"),
        (f"{PROOF}/prove.py", "half of the half cube is searched",
         "side, cube.half_side,", "side, 0.5 * cube.half_side,"),
        (f"{PROOF}/prove.py", "a halved box loses its upper half",
         "cell[2 * axis + 1] += 1", "cell[2 * axis + 1] += 0"),
        (f"{PROOF}/prove.py", "a point refutes that may break", "table[bit, HIGH] < 0.0", "table[bit, LOW] < 0.0"),
        (f"{LIMITS}/couple_index.py", "couples beside the smallest are forgotten", "(under + bent) * UP", "bent * UP"),
        (f"{LIMITS}/couple_index.py", "a tolerance moves no couple", "-= lb * lb * change", "-= 0.0 * change"),
        (f"{LIMITS}/holding_torque.py", "the arm's weight lifts",
         "subtract(allowed, scale(sign, arm))", "subtract(allowed, scale(-sign, arm))"),
        (f"{LIMITS}/effective_mass.py", "the mass of the proof's remainder is dropped",
         "out[row, LOW] -= (over + bent) * UP", "out[row, LOW] -= 0.0"),
        (f"{LIMITS}/friction.py", "joints turn alike in every sense",
         "second = scale(-1.0, second)", "second = scale(1.0, second)"),
        (f"{LIMITS}/friction.py", "the ball joints' square alone counts", "own + aside / qh", "own"),
        (f"{LIMITS}/friction.py", "what a bound leaves refutes", "(slack + ROUND * more)", "(0.0 * slack)"),
        (f"{PROOF}/ball_friction.py", "the elbow turns as the wrist", "rod, tuple(a - b for", "rod, tuple(a for"),
        (f"{LIMITS}/position_step.py", "a move is mirrored",
         "multiply(at(pose, a + z), at(pose, b + y)))", "multiply(at(pose, a + y), at(pose, b + z)))"),
        (f"{ENCLOSURE}/slope_pose.py", "a couple points aside", "x.times(-c) - y.times(s)", "x.times(-c) + y.times(s)"),
        ("delta_cad/mechanism/workspace.py", "half the cube's height", "+ 2.0 * self.half_side", "+ self.half_side"),
    ),
    "tests/optimizer/globalopt": (
        (f"{GLOBALOPT}/cutting_points.py", "a length forgets its rounding", "e = ROUND * (abs(c) + r)", "e = 0.0"),
        (f"{GLOBALOPT}/branch_and_bound.py", "a contraction is rounded inwards", "(left - PAD) -", "(left + PAD) +"),
        (f"{ENCLOSURE}/table.py", "a cut forgets its error",
         "cuts[count, i] = f * form[i]", "cuts[count, i] = f * form[i] * (i < 5)"),
        (f"{GLOBALOPT}/dual_simplex.py", "a sum of cuts forgets its rounding",
         "top + 2.0 * ROUND * (total + e) <", "top <"),
        (f"{GLOBALOPT}/design_box.py", "the space is rounded inwards",
         "np.array(low) - sizes", "np.array(low) + sizes"),
        (f"{GLOBALOPT}/design_box.py", "the outline is rounded down",
         "least + OUTWARDS * abs(reach))", "least - OUTWARDS * abs(reach))"),
    ),
    "tests/optimizer/certify": (
        (f"{CERTIFY}/tiling.py", "a box beside the cube is a tile", "not 0 <= i < 2**k", "not 0 <= i <= 2**k"),
        (f"{ENCLOSURE}/slope_pose.py", "a chain takes its neighbour's forearms",
         "[i - 2], self.forearm[i - 1]", "[i - 1], self.forearm[i]"),
        ("delta_cad/mechanism/limits/angles/lean.py", "rods lean to one side only",
         "for side in (1.0, -1.0)", "for side in (-1.0,)"),
        (f"{CERTIFY}/gravity.py", "a rod's centre lies on its line",
         "off = mass * math.hypot(y, z) / rods[0]", "off = 0.0"),
        (f"{CERTIFY}/gravity.py", "a smaller force passes",
         "Fraction(condition.force) < Fraction(self.force)", "Fraction(condition.force) < 0"),
    ),
}
# fmt: on
"""Folder of tests -> (file, what is wrong, text that stands there exactly once, what replaces it)."""
