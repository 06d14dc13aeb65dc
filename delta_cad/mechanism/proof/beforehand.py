"""Compiles the proof over a cube before anybody needs it, in a process beside the one that will."""

from __future__ import annotations

from collections.abc import Iterator

from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.limits import Limits
from delta_cad.mechanism.proof.prove import prove
from delta_cad.mechanism.workspace import Cube

_ANY = DeltaGeometry(base_radius=0.03, platform_radius=0.02, upper_arm_length=0.1, forearm_length=0.15)


def results(_order: object) -> Iterator[None]:
    """Proves something of any machine, as `WorkerProcess` asks for it: what that compiles is kept on disk."""
    prove(_ANY, Cube(0.1, 0.01), Limits.of(), max_boxes=1)
    yield None
