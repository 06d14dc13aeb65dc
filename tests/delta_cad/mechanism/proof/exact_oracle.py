"""The mechanism in 50 decimal digits, from the paper's closure A cos + B sin + C = 0; no formula of the package."""

from __future__ import annotations

from decimal import Decimal, getcontext, localcontext

import numpy as np

from delta_cad.mechanism import DeltaGeometry
from delta_cad.mechanism.limits import (
    AssemblyMode,
    CoupleIndex,
    EffectiveMass,
    ElbowAngle,
    Friction,
    HandleInertia,
    HoldingTorque,
    Kappa,
    Lean,
    Limits,
    PoseLimit,
    PositionStep,
    Reach,
    Shoulder,
    Torque,
)

DIGITS = 50
D = Decimal


def cosine(x: Decimal) -> Decimal:
    """Taylor's series at x / 2^10, doubled back ten times; loses 6 digits of the context's."""
    x /= 1024
    total = term = D(1)
    for n in range(1, 20):  # |x| < 0.01: the terms are below 1e-100
        term = -term * x * x / ((2 * n - 1) * (2 * n))
        total += term
    for _ in range(10):
        total = 2 * total * total - 1
    return total


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _dot(a, b):
    return sum((x * y for x, y in zip(a, b, strict=True)), D(0))


def eigenvalues(m: list[list[Decimal]]) -> tuple[Decimal, Decimal]:
    """Smallest and largest eigenvalue of a symmetric matrix: Newton on the cubic from beyond either end."""
    trace = m[0][0] + m[1][1] + m[2][2]
    minors = sum((m[i][i] * m[j][j] - m[i][j] ** 2 for i, j in ((0, 1), (0, 2), (1, 2))), D(0))
    det = _dot(m[0], _cross(m[1], m[2]))
    ends, beyond = [], sum((abs(v) for row in m for v in row), D(0))
    for x in (-beyond, beyond):
        for _ in range(300):  # from outside all roots Newton is monotone; a double root only halves the distance
            slope = 3 * x * x - 2 * trace * x + minors
            step = (((x - trace) * x + minors) * x - det) / slope if slope else D(0)
            x -= step
            if abs(step) <= abs(x) * D(10) ** (6 - getcontext().prec):
                break
        ends.append(x)
    return ends[0], ends[1]


def exact_inertia(masses: HandleInertia, la: Decimal, forearms: list, directions: list) -> list[list[Decimal]]:
    """The handle's inertia from the kinetic energy of what moves: energies of three velocities and their sums.

    The elbow moves with u along its direction e; a rod keeps its length, so that s . (v - u e) = 0.

    Args:
        masses: What moves.
        la: L_A, m.
        forearms: s, by chain.
        directions: e, by chain.
    """
    carried, at_elbow, cross, joint = (
        D(v) for v in (masses.carried_mass, masses.elbow_mass, masses.cross_mass, masses.joint_inertia)
    )

    def twice_energy(v: list[Decimal]) -> Decimal:
        total = carried * _dot(v, v)
        for s, e in zip(forearms, directions, strict=True):
            speed = _dot(s, v) / _dot(s, e)
            elbow = [speed * x for x in e]
            total += at_elbow * _dot(elbow, elbow) + 2 * cross * _dot(elbow, v) + joint * (speed / la) ** 2
        return total

    unit = [[D(int(i == j)) for j in range(3)] for i in range(3)]
    alone = [twice_energy(v) for v in unit]
    both = {
        (i, j): twice_energy([a + b for a, b in zip(unit[i], unit[j], strict=True)])
        for i, j in ((0, 1), (0, 2), (1, 2))
    }
    return [
        [alone[i] if i == j else (both[min(i, j), max(i, j)] - alone[i] - alone[j]) / 2 for j in range(3)]
        for i in range(3)
    ]


def exact_held(held: HoldingTorque, la: Decimal, det: Decimal, crosses: list, turns: list, arms: list) -> list:
    """What is left of each joint's torque, times det S, for both signs: by the work of gravity at the unit joint rate.

    Where det S > 0 it is the joint's own margin; below, the sign alone would say nothing.
    """
    m = held.masses
    gravity, side = [D(m.gravity_x), D(0), D(m.gravity_z)], D(m.gravity_y)
    size = (gravity[0] ** 2 + side**2 + gravity[2] ** 2).sqrt()
    turning = (D(m.arm_moment) ** 2 + D(m.cross_moment) ** 2).sqrt()
    force = D(held.force) + size * D(m.loose_mass) + side * D(m.carried_mass)
    left = D(held.torque_max) - size * D(m.loose_moment) - side * turning
    out = []
    for (c, s), (w, cos, sin, direction), face in zip(turns, arms, crosses, strict=True):
        lever = [la * w * x for x in face]  # det times the platform's velocity
        arm = [cos * c, cos * s, sin]
        turned = [D(m.arm_moment) * e - D(m.cross_moment) * a for e, a in zip(direction, arm, strict=True)]
        power = D(m.carried_mass) * _dot(gravity, lever) + det * _dot(gravity, turned)
        most = force * _dot(lever, lever).sqrt()
        out += [det * left - most - power, det * left - most + power]
    return out


def signed_sums(vectors: list) -> list:
    """The sums of three vectors, the first with its sign and the others with either."""
    return [
        [x + second * y + third * z for x, y, z in zip(*vectors, strict=True)]
        for second, third in ((1, 1), (1, -1), (-1, 1), (-1, -1))
    ]


def exact_frictions(limit: Friction, la: Decimal, forearms: list, levers: list) -> list:
    """What is left of the square of the friction allowed, for each sense in which the joints turn."""
    rows = [[D(limit.drive) * x / (la * w) for x in s] for s, w in zip(forearms, levers, strict=True)]
    return [
        D(limit.friction_max) ** 2 - (abs(z) + D(limit.upright)) ** 2 - ((x * x + y * y).sqrt() + D(limit.level)) ** 2
        for x, y, z in signed_sums(rows)
    ]


def exact_margins(
    g: DeltaGeometry, limits: Limits, p: tuple[float, float, float]
) -> dict[type[PoseLimit], list[Decimal | None]]:
    """The margins of README (31), (40), (49), (55), (59) at a position, doubles exact; None where they have none."""
    with localcontext() as context:
        context.prec = DIGITS + 10
        la, lb = D(g.upper_arm_length), D(g.forearm_length)
        first = D(g.base_radius) - D(g.platform_radius)
        radii = [first, first + D(g.side_shift), first + D(g.side_shift)]
        x, y, z = map(D, p)
        cosine_1 = D(g.side_cosine)
        root = (1 - cosine_1**2).sqrt()
        turns = [(D(1), D(0)), (cosine_1, root), (cosine_1, -root)]
        forearms, arms, w2s, coordinates = [], [], [], []
        for (c, s), a in zip(turns, radii, strict=True):
            big_a, big_b = 2 * la * (a - (x * c + y * s)), -2 * la * z
            big_c = la * la - lb * lb + a * a + x * x + y * y + z * z - 2 * a * (x * c + y * s)
            h = big_c**2 - big_a**2 - big_b**2
            w2s.append(-h / (4 * la * la))
            coordinates.append(-x * s + y * c)
            if h > 0:
                continue
            both = []
            for side in (1, -1):
                cos = (-big_a * big_c + side * big_b * (-h).sqrt()) / (big_a**2 + big_b**2)
                sin = (-big_b * big_c - side * big_a * (-h).sqrt()) / (big_a**2 + big_b**2)
                both.append((cos, sin))
            cos, sin = max(both)  # elbows outwards: the larger cosine
            elbow = [(a + la * cos) * c, (a + la * cos) * s, la * sin]
            forearm, direction = [x - elbow[0], y - elbow[1], z - elbow[2]], [-sin * c, -sin * s, cos]
            forearms.append(forearm)
            arms.append((_dot(forearm, direction), cos, sin, direction))
        out: dict[type[PoseLimit], list[Decimal | None]] = {
            type(limit): [None] * limit.enclosure.rows for limit in limits
        }
        half_pi = D("1.57079632679489661923132169163975144209858469968755291")
        if reach := limits.get(Reach):
            out[Reach] = [w2 - D(reach.elbow_arm_min) ** 2 for w2 in w2s]
        if lean := limits.get(Lean):
            out[Lean] = [lb * cosine(half_pi - D(lean.lean_max)) - abs(t) for t in coordinates]
        if len(forearms) < 3 or any(arm[0] == 0 for arm in arms):
            return out
        crosses = [_cross(forearms[i - 2], forearms[i - 1]) for i in range(3)]
        det = _dot(forearms[0], crosses[0])
        if limits.get(AssemblyMode):
            out[AssemblyMode] = [det]
        if torque := limits.get(Torque):
            lever = D(torque.force) * la / D(torque.torque_max)
            out[Torque] = [det * det - (lever * arms[i][0]) ** 2 * _dot(crosses[i], crosses[i]) for i in range(3)]
        if held := limits.get(HoldingTorque):
            out[HoldingTorque] = exact_held(held, la, det, crosses, turns, arms)
        if shoulder := limits.get(Shoulder):
            low, high = D(shoulder.shoulder_min), D(shoulder.shoulder_max)
            middle, half = (low + high) / 2, (high - low) / 2
            out[Shoulder] = [
                la * (cos * cosine(middle) + sin * cosine(half_pi - middle) - cosine(half)) for _, cos, sin, _ in arms
            ]
        if elbow := limits.get(ElbowAngle):
            out[ElbowAngle] = [
                2 * la * (_dot(s, [cos * c, cos * e, sin]) + lb * cosine(D(elbow.angle_min)))
                for s, (_, cos, sin, _), (c, e) in zip(forearms, arms, turns, strict=True)
            ]
        if kappa := limits.get(Kappa):
            rows = [[v / (la * arm[0]) for v in forearm] for forearm, arm in zip(forearms, arms, strict=True)]
            smallest, largest = eigenvalues([[_dot(r, s) for s in rows] for r in rows])
            out[Kappa] = [D(kappa.kappa_max) ** 2 * smallest - largest]
        if mass := limits.get(EffectiveMass):
            m = exact_inertia(mass.inertia, la, forearms, [arm[3] for arm in arms])
            out[EffectiveMass] = [D(mass.mass_max) - eigenvalues(m)[1]]
        if rubbing := limits.get(Friction):
            out[Friction] = exact_frictions(rubbing, la, forearms, [arm[0] for arm in arms])
        if step := limits.get(PositionStep):
            moves = [[la * arm[0] * x for x in face] for arm, face in zip(arms, crosses, strict=True)]
            allowed = (D(step.step_max) / D(step.count) * det) ** 2
            out[PositionStep] = [allowed - _dot(way, way) for way in signed_sums(moves)]
        if couple := limits.get(CoupleIndex):
            axes = [[-s, c, D(0)] for c, s in turns]
            carried_load = [_cross(axis, forearm) for axis, forearm in zip(axes, forearms, strict=True)]
            products = [[_dot(m, n) for n in carried_load] for m in carried_load]
            out[CoupleIndex] = [eigenvalues(products)[0] - (D(couple.couple_index_min) * lb) ** 2]
        return out


def samples(box: np.ndarray, rng: np.random.Generator, n: int) -> np.ndarray:
    """(n, 3) points of a box (centre, half sides): corners first, then any."""
    unit = rng.uniform(-1.0, 1.0, (n, 3))
    unit[: n // 2] = np.sign(unit[: n // 2])
    return np.clip(box[:3] + unit * box[3:6], box[:3] - box[3:6], box[:3] + box[3:6])
