"""Proof of a design over every point of its cube: branch and bound with affine forms, README (28)-(36).

What is proved is about the doubles given, taken as exact numbers: lengths in metres, the cosine of the azimuth of
chains 1 and 2, the cube between the doubles `cube.lower` and `cube.upper`, and limits in SI units. The half y >= 0 is
searched; the other half is its mirror image, in which chains 1 and 2 change places: no other symmetry is used.

The first proof compiles for some seconds; later runs read what was compiled.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure.affine_form import ROUND
from delta_cad.mechanism.enclosure.pose import TOLERANCE
from delta_cad.mechanism.enclosure.table import CENTRE, HIGH, LOW
from delta_cad.mechanism.geometry import DeltaGeometry, require_tolerance
from delta_cad.mechanism.limits import POSE_LIMITS, Limits, PoseLimit
from delta_cad.mechanism.proof.findings import Box, Finding, Proof
from delta_cad.mechanism.proof.margins import BITS, MARGINS, margins, numbers, room
from delta_cad.mechanism.workspace import Cube

Progress = Callable[[int, float], object]  # boxes examined, share of the cube that is done -> whether to end
DEEPEST = 40  # Halvings of an edge at which a box is given up: 2^-40 of it, 1e-13 m, where roundings rule.
# Boxes are halved along z until they are so flat: a figure is worst on the bottom or the top face as a rule, and there
# a thin layer is what remains. Of 60 random designs, kappa 2e-4 above its worst, this takes 0.43 of the boxes of cubes.
_FLAT = 3.0
CHUNK = 20_000  # Boxes between two reports of progress; some 50 ms.
_MASKS = np.array([BITS[limit] for limit in POSE_LIMITS], dtype=np.int64)
_STRICT = sum(BITS[limit] for limit in POSE_LIMITS if limit.strict)
_REFUTED, _GIVEN_UP = 1, 2


def prove(
    g: DeltaGeometry,
    cube: Cube,
    limits: Limits,
    *,
    tolerance: float = 0.0,
    max_boxes: int = 5_000_000,
    progress: Progress | None = None,
) -> Proof:
    """Decides each limit for every point of the cube.

    Args:
        g: The mechanism.
        cube: The cube.
        limits: The limits.
        tolerance: Of every length and offset of every chain, m, README (43): a limit is proved for all machines within
            it, refuted where all of them break it, else undecided.
        max_boxes: Boxes after which what is open is undecided.
        progress: Called now and then with the boxes examined and the share of the cube that is done; what it returns
            ends the proof if it is true, and what is open is undecided.

    Returns:
        The findings, and the boxes that cover the cube. A refuted limit is dropped and the others go on; if reach
        is refuted the others are undecided, because they mean nothing where a chain is open.

    Raises:
        GeometryError: `require_tolerance` refuses the tolerance.
    """
    require_tolerance(g, tolerance)
    pose, work, table = room()
    given = numbers(g, limits, tolerance)
    origin, edges = half_of(cube)
    frame = np.stack([origin, edges, cube.upper])
    bits = sum(BITS[type(limit)] for limit in limits)
    stack = np.zeros((3 * DEEPEST + 8, 7), dtype=np.int64)
    stack[0, 6] = bits
    state = np.array([1, bits, 0, 0], dtype=np.int64)  # boxes on the stack, bits still open, boxes examined, leaves
    count = len(POSE_LIMITS)
    fate, points, stuck = np.zeros(count, np.int64), np.zeros((count, 3)), np.zeros((count, 6), np.int64)
    leaves = []
    while state[0] > 0 and state[1] != 0 and state[2] < max_boxes:
        budget = min(CHUNK, max_boxes - int(state[2]))
        found = np.empty((budget, 6), dtype=np.int64)
        state[3] = 0
        _search(frame, given, stack, state, fate, points, stuck, found, pose, work, table, budget)
        leaves.append(found[: state[3]].copy())
        if progress is not None and progress(int(state[2]), _share(leaves)):
            break
    if state[0] > 0:
        for n, limit in enumerate(POSE_LIMITS):
            if state[1] & BITS[limit]:
                fate[n], stuck[n] = _GIVEN_UP, stack[state[0] - 1, :6]
    if fate[0]:  # without reach the others have no meaning
        fate[1:] = np.where(fate[1:] == 0, _GIVEN_UP, fate[1:])
        stuck[1:] = np.where((fate[1:] == _GIVEN_UP)[:, None], stuck[0], stuck[1:])
    covered = np.concatenate(leaves) if leaves else np.empty((0, 6), dtype=np.int64)
    order = {kind: n for n, kind in enumerate(POSE_LIMITS)}
    findings = tuple(
        _finding(limit, g, int(fate[n]), points[n], _box(origin, edges, stuck[n]))
        for limit, n in ((limit, order[type(limit)]) for limit in limits)
    )
    return Proof(findings, covered, int(state[2]))


def half_of(cube: Cube) -> tuple[np.ndarray, np.ndarray]:
    """Gives the half y >= 0 of a cube, which is searched: (3,) its lower corner and (3,) its edges, m."""
    origin = np.array([cube.lower[0], 0.0, cube.lower[2]])
    return origin, cube.upper - origin


def _finding(
    limit: PoseLimit,
    g: DeltaGeometry,
    fate: int,
    point: np.ndarray,
    box: Box,
) -> Finding:
    """The record of one limit."""
    name, bound = limit.name, limit.thresholds()
    if fate == _REFUTED:
        return Finding(name, "refuted", bound, point=_triple(point), value=limit.broken(g, point))
    return Finding(name, "undecided", bound, box=box) if fate == _GIVEN_UP else Finding(name, "proved", bound)


def _triple(point: np.ndarray) -> tuple[float, float, float]:
    return (float(point[0]), float(point[1]), float(point[2]))


def _box(origin: np.ndarray, edges: np.ndarray, cell: np.ndarray) -> Box:
    """Corners of a box of the subdivision, m."""
    size = edges / 2.0 ** cell[::2]
    return _triple(origin + cell[1::2] * size), _triple(origin + (cell[1::2] + 1) * size)


def _share(leaves: list[np.ndarray]) -> float:
    """Share of the cube that the leaves cover."""
    return float(sum((2.0 ** -chunk[:, ::2].sum(axis=1)).sum() for chunk in leaves))


@compiled
def _place(frame, cell, box):
    """Centre, half sides and error of a box of the subdivision, so that it contains the exact one."""
    error = 0.0
    origin, edges = frame[0], frame[1]
    for i in range(3):
        part = 2.0 ** -(cell[2 * i] + 1.0)
        box[i] = origin[i] + edges[i] * ((2.0 * cell[2 * i + 1] + 1.0) * part)
        box[3 + i] = edges[i] * part
        error = max(error, ROUND * (abs(origin[i]) + edges[i]))
    box[6] = error


@compiled
def _corner(frame, box, table, row, point):
    """The corner of the box, kept inside the cube, at which a margin's form is smallest."""
    for i in range(3):
        x = box[i] - box[3 + i] if table[row, CENTRE + 1 + i] > 0.0 else box[i] + box[3 + i]
        point[i] = min(max(x, frame[0, i]), frame[2, i])
        point[3 + i] = 0.0
    point[6] = 0.0


@compiled
def _drop(bits, state, fate, how, points, stuck, point, cell):
    """Closes the limits that have one of the bits; all of them with reach, the first."""
    for n in range(len(_MASKS)):
        if _MASKS[n] & bits & state[1]:
            fate[n] = how
            for i in range(3):
                points[n, i] = point[i]
            for i in range(6):
                stuck[n, i] = cell[i]
            state[1] = 0 if n == 0 else state[1] & ~_MASKS[n]


@compiled
def _search(frame, k, stack, state, fate, points, stuck, found, pose, work, table, budget):
    """Examines up to `budget` boxes, depth first; see `prove` for the arguments."""
    box, point, cell = np.empty(7), np.empty(7), np.empty(7, dtype=np.int64)
    while budget > 0 and state[0] > 0 and state[1] != 0:
        budget -= 1
        state[0] -= 1
        state[2] += 1
        for i in range(7):
            cell[i] = stack[state[0], i]
        _place(frame, cell, box)
        pending = cell[6] & state[1]
        margins(box, k, pending, pose, work, table)
        suspect = -1
        for bit in range(MARGINS):
            if not (pending >> bit) & 1:
                continue
            if table[bit, LOW] > 0.0 or (table[bit, LOW] == 0.0 and not (_STRICT >> bit) & 1):
                pending &= ~(1 << bit)
            elif suspect < 0:
                reach = abs(table[bit, CENTRE + 1]) + abs(table[bit, CENTRE + 2]) + abs(table[bit, CENTRE + 3])
                if table[bit, CENTRE] - reach < 0.0 or (k[TOLERANCE] > 0.0 and table[bit, LOW] < 0.0):
                    suspect = bit
        if suspect >= 0:
            _corner(frame, box, table, suspect, point)
            margins(point, k, pending, pose, work, table)
            broken = unprovable = 0
            for bit in range(MARGINS):
                if (pending >> bit) & 1 and table[bit, HIGH] < 0.0:
                    broken |= 1 << bit
                elif (pending >> bit) & 1 and k[TOLERANCE] > 0.0 and not table[bit, LOW] >= 0.0:
                    unprovable |= 1 << bit  # some machine may break it there, and a smaller box is no help
            if broken:
                _drop(broken, state, fate, _REFUTED, points, stuck, point, cell)
                pending &= state[1]
            if unprovable & state[1]:
                _drop(unprovable, state, fate, _GIVEN_UP, points, stuck, point, cell)
                pending &= state[1]
        axis = 0 if box[3] >= box[4] else 1
        if box[5] * _FLAT > box[3 + axis]:
            axis = 2
        if pending and cell[2 * axis] >= DEEPEST:
            _drop(pending, state, fate, _GIVEN_UP, points, stuck, point, cell)
            pending &= state[1]
        if pending == 0:
            for i in range(6):
                found[state[3], i] = cell[i]
            state[3] += 1
            continue
        cell[6] = pending
        cell[2 * axis] += 1
        cell[2 * axis + 1] *= 2
        for _half in range(2):
            for i in range(7):
                stack[state[0], i] = cell[i]
            state[0] += 1
            cell[2 * axis + 1] += 1
