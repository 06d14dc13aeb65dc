"""Exploded view: for every placed part a direction and a distance, so that no two parts' boxes meet.

The machine comes apart in groups: what lies on the ground, each chain's drive, each chain's rods, the platform. In a
group the part that holds most others stays; the others leave it along the axis of what they are turned about (a screw
towards its head, else away from that part), the outermost last and a screw after all that it goes through, each as far
as it takes to clear all before it.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Mesh, Meshes
from delta_cad.design.stands import Gap, gaps_of
from delta_cad.mechanism.placement import CHAINS, chain_stand
from delta_cad.solids.part import Occurrence

_BONDED = ("joint_ball",)  # what stays on its bar
GAP_MM = 4.0  # between the boxes of two parts of a group
_APART_MM = 18.0  # between the boxes of two groups
ROUND = 0.03  # relative difference up to which two principal moments are those of a body of revolution
X, Y, Z = range(3)


@dataclass(eq=False)
class _Unit:
    """Parts that go together, in their group's frame.

    Attributes:
        names: Occurrences.
        boxes: (n, 2, 3) lowest and highest corners, mm; moved as they are placed.
        axis: Along which of the frame's axes it leaves.
        sense: 1 or -1 along it; 0: away from what stays.
        alike: What parts that leave side by side have in common.
    """

    names: tuple[str, ...]
    boxes: np.ndarray
    axis: int
    sense: int
    alike: str

    @property
    def volume(self) -> float:
        """Volume of the first box, mm^3."""
        return float(np.prod(self.boxes[0, 1] - self.boxes[0, 0]))

    def end(self, sense: int) -> float:
        """How far it reaches along its axis, mm."""
        return sense * float((sense * self.boxes[:, (1 + sense) // 2, self.axis]).max())


@dataclass
class _Group:
    """A group that came apart.

    Attributes:
        frame: (4, 4) of the group in the base frame, mm.
        moves: Occurrence -> (3,) how far it moves, group's frame.
        points: (n, 3) corners of all boxes where they end, base frame.
    """

    frame: np.ndarray
    moves: dict[str, np.ndarray]
    points: np.ndarray


def exploded(assembly: Assembly, meshes: Meshes) -> dict[str, np.ndarray]:
    """Computes how far each part moves in the view in which the machine is wholly apart.

    Args:
        assembly: The machine; it comes apart from its home position.
        meshes: Part number -> mesh, mm.

    Returns:
        Occurrence -> (3,) displacement in the base frame, mm.
    """
    taken = _Taken(assembly, meshes)
    ground = taken.group(lambda o: o.link == "base" and (chain_of(o.name) is None or taken.upright(o)), np.eye(4), Z)
    top = taken.group(lambda o: o.link == "platform", np.eye(4), Z)
    moves = _moved(ground, np.array([0.0, 0.0, -2.0 * _APART_MM]))
    height, geometry = -np.inf, assembly.placement.geometry
    gaps = gaps_of(geometry)
    for i in CHAINS:
        stand, adjacent = chain_stand(geometry, i), (gaps[(i - 1) % len(gaps)], gaps[i % len(gaps)])
        u = stand[:3, 0]
        drive = taken.group(
            lambda o, i=i: (chain_of(o.link) == i and not o.link.startswith(("rod", "spring"))) or taken.of(o, i),
            stand,
            Y,
        )
        rods = taken.group(
            lambda o, i=i: chain_of(o.link) == i and o.link.startswith(("rod", "spring")), taken.rod_frame(i), X
        )
        out = (
            max(_outwards(drive.points @ stand[:3, :3], adjacent), _outwards(rods.points @ stand[:3, :3], adjacent)) * u
        )
        lift = _lift(drive.points, rods.points)
        moves |= _moved(drive, out)
        moves |= _moved(rods, out + lift * np.array([0.0, 0.0, 1.0]))
        height = max(height, float((rods.points[:, Z] + lift).max(initial=-np.inf)))
    over = height - top.points[:, Z].min(initial=np.inf) + _APART_MM
    moves |= _moved(top, np.array([0.0, 0.0, max(over, 0.0) if np.isfinite(over) else 0.0]))
    return moves


def exploded_chain(assembly: Assembly, meshes: Meshes, parts: Sequence[Occurrence]) -> dict[str, np.ndarray]:
    """Computes how far each of some parts of chain 0 moves where they alone are taken apart; as `exploded`."""
    names, stand = {o.name for o in parts}, chain_stand(assembly.placement.geometry, 0)
    return _moved(
        _Taken(assembly, meshes).group(lambda o: o.name in names, stand, Y),
        np.zeros(3),
    )


def _moved(group: _Group, by: np.ndarray) -> dict[str, np.ndarray]:
    return {name: group.frame[:3, :3] @ move + by for name, move in group.moves.items()}


def _outwards(points: np.ndarray, adjacent: tuple[Gap, Gap]) -> float:
    """How far a group moves along its chain's radius until it is in that chain's share of the round, mm.

    Args:
        points: (n, 3) of the group, along the chain's directions.
        adjacent: The gaps before and after the chain, of which its share has half.
    """
    off = -np.inf
    for side, gap in zip((-1.0, 1.0), adjacent, strict=True):
        needed = side * points[:, Y] * gap.half_cosine / gap.half_sine - points[:, X]
        off = max(off, float(needed.max(initial=-np.inf)))
    return max(0.0, off + _APART_MM)


def _lift(below: np.ndarray, above: np.ndarray) -> float:
    """How far a group moves up to be above another, mm."""
    if not len(below) or not len(above):
        return 0.0
    return max(0.0, float(below[:, Z].max() - above[:, Z].min()) + _APART_MM)


class _Taken:
    """The machine at home, from which groups are taken; a part is in the first that asks for it."""

    def __init__(self, assembly: Assembly, meshes: Meshes) -> None:
        self._assembly, self._meshes, self._left = assembly, meshes, dict.fromkeys(o.name for o in assembly.occurrences)
        self._poses = assembly.poses(assembly.home_mm)
        self._links = assembly.placement(assembly.home_mm)
        self._holds = Counter(name for contact in assembly.contacts for name in (contact.a, contact.b))
        self._axes: dict[str, np.ndarray | None] = {}
        self._numbers = {o.name: o.part.number for o in assembly.occurrences}
        on_one = [c for c in assembly.contacts if self._numbers.get(c.b) in _BONDED]
        self._bonded = {c.b: c.a for c in on_one if c.kind == "cylinder"}
        self._balls = {c.b: c.a for c in assembly.contacts if c.kind == "ball"}

    def rod_frame(self, i: int) -> np.ndarray:
        """Gives the frame of a chain's rods, its x along them."""
        return self._links[f"rod_{i}_0"]

    def of(self, o: Occurrence, i: int) -> bool:
        """Decides whether a part of the base belongs to a chain."""
        return o.link == "base" and chain_of(o.name) == i

    def upright(self, o: Occurrence) -> bool:
        """Decides whether a part is turned about an upright axis."""
        axis = self._axis(o.part.number)
        return axis is not None and abs((self._poses[o.name][:3, :3] @ axis)[Z]) > 0.9

    def group(self, wanted: Callable[[Occurrence], bool], frame: np.ndarray, default: int) -> _Group:
        """Takes the parts that are wanted, and takes them apart.

        Args:
            wanted: Which.
            frame: (4, 4) frame along whose axes they leave.
            default: Axis of those that are not turned about one.
        """
        found = [o for o in self._assembly.occurrences if o.name in self._left and wanted(o)]
        for o in found:
            del self._left[o.name]
        clusters: dict[str, list[Occurrence]] = {}
        for o in found:
            whole = o.part.piece_of or o.part.number
            pieces = f"{whole} of chain {chain_of(o.name)}" if whole in self._drawn_in_pieces else o.name
            clusters.setdefault(self._bonded.get(o.name, pieces), []).append(o)
        to_group = np.linalg.inv(frame)
        units = [self._unit(one, to_group, default) for one in clusters.values()]
        moves = apart(units, lambda unit: max(self._holds[name] for name in unit.names))
        corners = [box[k, range(3)] for unit in units for box in unit.boxes for k in np.ndindex(2, 2, 2)]
        points = np.array(corners).reshape(-1, 3)
        return _Group(frame, moves, points @ frame[:3, :3].T + frame[:3, 3])

    @cached_property
    def _drawn_in_pieces(self) -> set[str]:
        return {part.piece_of for part in self._assembly.parts if part.piece_of}

    def _unit(self, parts: Sequence[Occurrence], to_group: np.ndarray, default: int) -> _Unit:
        boxes = []
        for o in parts:
            pose = to_group @ self._poses[o.name]
            points = self._meshes[o.part.number].vertices @ pose[:3, :3].T + pose[:3, 3]
            boxes.append([points.min(axis=0), points.max(axis=0)])
        first, names = parts[0], tuple(o.name for o in parts)
        drawn_in_pieces = (first.part.piece_of or first.part.number) in self._drawn_in_pieces
        axis, sense = (default, 0) if drawn_in_pieces else self._leaves(first, to_group, default)
        names = tuple(o.name for o in parts)
        return _Unit(names, np.array(boxes), axis, sense, first.part.number if len(parts) == 1 else names[0])

    def _leaves(self, o: Occurrence, to_group: np.ndarray, default: int) -> tuple[int, int]:
        """Along which axis of its group a part leaves, and in which sense; 0 where nothing tells."""
        turned = self._axis(o.part.number)
        if o.link.startswith("spring"):
            return Z, 0  # off both rods at once
        if turned is None:
            return default, 0
        direction = to_group[:3, :3] @ self._poses[o.name][:3, :3] @ turned
        axis = int(np.abs(direction).argmax())
        if "screw" in o.part.number:  # its axis points to its head
            return axis, 1 if direction[axis] > 0.0 else -1
        if o.name in self._balls:  # a seat opens towards its ball
            towards = to_group[:3, :3] @ (self._middle(self._balls[o.name]) - self._middle(o.name))
            return axis, 1 if towards[axis] > 0.0 else -1
        return axis, 0

    def _axis(self, number: str) -> np.ndarray | None:
        """Axis of revolution of a part, looked for once."""
        if number not in self._axes:
            self._axes[number] = revolution_axis(self._meshes[number])
        return self._axes[number]

    def _middle(self, name: str) -> np.ndarray:
        """(3,) mean of a placed part's vertices, base frame, mm."""
        pose = self._poses[name]
        return pose[:3, :3] @ self._meshes[self._numbers[name]].vertices.mean(axis=0) + pose[:3, 3]


def apart(units: list[_Unit], holds: Callable[[_Unit], int]) -> dict[str, np.ndarray]:
    """Takes a group apart: each part leaves the one that holds most others, as far as it takes to clear what stands.

    What is like that one stays, too.

    Args:
        units: The parts; like ones that leave side by side become one, and boxes are moved to where they end.
        holds: How many others a part holds.

    Returns:
        Occurrence -> (3,) move, group's frame, mm.
    """
    if not units:
        return {}
    stays = max(units, key=lambda unit: (holds(unit), unit.volume, unit.names))
    middle = (stays.boxes[:, 0].min(axis=0) + stays.boxes[:, 1].max(axis=0)) / 2.0
    rows: dict[tuple[str, int, int, int], _Unit] = {}
    still = [unit for unit in units if unit.alike == stays.alike]
    led = [unit for unit in units if unit.sense]  # screws above all, whose heads stand on what they go through
    for unit in units:
        if unit not in still:
            off = float(unit.boxes[:, :, unit.axis].mean() - middle[unit.axis])
            unit.sense = unit.sense or (1 if off >= 0.0 else -1)
            key = (unit.alike, unit.axis, unit.sense, round(unit.end(unit.sense)))
            row = rows.setdefault(key, unit)
            if row is not unit:
                row.names, row.boxes = row.names + unit.names, np.concatenate([row.boxes, unit.boxes])

    def beyond(unit: _Unit) -> float:
        return unit.sense * (unit.end(unit.sense) - float(middle[unit.axis]))

    def far(unit: _Unit) -> tuple[float, bool, float, tuple[str, ...]]:
        ways = [other for other in rows.values() if (other.axis, other.sense) == (unit.axis, unit.sense)]
        through = [beyond(other) for other in ways if unit in led and other not in led and _meets(unit, other)]
        return (max(beyond(unit), *through, -np.inf), bool(through), -unit.volume, unit.names)

    moves = {name: np.zeros(3) for unit in still for name in unit.names}
    static = np.concatenate([unit.boxes for unit in still])
    for unit in sorted(rows.values(), key=far):  # all keys are of where parts stand in the machine
        move = np.zeros(3)
        move[unit.axis] = unit.sense * _step(unit, static)
        unit.boxes = unit.boxes + move
        static = np.concatenate([static, unit.boxes])
        moves |= dict.fromkeys(unit.names, move)
    units[:] = [*still, *rows.values()]
    return moves


def _meets(one: _Unit, other: _Unit) -> bool:
    """Whether a box of one unit and one of another have a volume in common."""
    low = np.maximum(one.boxes[:, None, 0], other.boxes[None, :, 0])
    high = np.minimum(one.boxes[:, None, 1], other.boxes[None, :, 1])
    return bool((high > low).all(axis=-1).any())


def _step(unit: _Unit, static: np.ndarray) -> float:
    """The least way along a part's axis after which its boxes clear those that stand, mm."""
    a, others = unit.axis, [axis for axis in range(3) if axis != unit.axis]
    low, high = static[None, :, 0] - GAP_MM, static[None, :, 1] + GAP_MM
    own_low, own_high = unit.boxes[:, None, 0], unit.boxes[:, None, 1]
    meets = ((own_high > low) & (own_low < high))[..., others].all(axis=-1)
    if unit.sense > 0:
        first, last = low[..., a] - own_high[..., a], high[..., a] - own_low[..., a]
    else:
        first, last = own_low[..., a] - high[..., a], own_high[..., a] - low[..., a]
    step = 0.0
    for begin, end in sorted(zip(first[meets], last[meets], strict=True)):
        if begin < step < end:
            step = float(end)
    return step


def revolution_axis(mesh: Mesh) -> np.ndarray | None:
    """Finds the axis of a body whose principal moments are those of a body of revolution.

    Returns:
        (3,) unit vector, towards its heavier end; None where two moments are not alike, or all three are.
    """
    a, b, c = np.moveaxis(mesh.triangles - mesh.vertices.mean(axis=0), 1, 0)
    volumes = (a * np.cross(b, c)).sum(axis=1) / 6.0
    total = volumes.sum()
    if not total > 0.0:
        return None
    middle = (volumes[:, None] * (a + b + c)).sum(axis=0) / (4.0 * total)
    second = sum(np.einsum("n,ni,nj->ij", volumes, v, v) for v in (a, b, c, a + b + c)) / 20.0
    values, vectors = np.linalg.eigh(second / total - np.outer(middle, middle))
    alike = np.diff(values) < ROUND * values[1:]
    if alike.all() or not alike.any():
        return None
    axis = vectors[:, 2] if alike[0] else vectors[:, 0]
    along = mesh.vertices @ axis
    heavier = (mesh.vertices.mean(axis=0) + middle) @ axis - (along.max() + along.min()) / 2.0
    return axis if heavier >= 0.0 else -axis


def chain_of(name: str) -> int | None:
    """Gives the chain of an occurrence, the first number that stands alone in its name; None if there is none."""
    match = re.search(r"_(\d)(?=_|$)", name)
    return int(match[1]) if match else None
