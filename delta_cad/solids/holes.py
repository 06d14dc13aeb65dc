"""Groups of equal bores, joined for the hole table."""

from __future__ import annotations

from collections.abc import Iterable

from delta_cad.solids.part import Hole


def merged(holes: Iterable[Hole]) -> tuple[Hole, ...]:
    """Groups of equal diameter joined, because a bore in a solid is recognised by its diameter."""
    groups: dict[float, list[Hole]] = {}
    for hole in holes:
        groups.setdefault(round(hole.diameter_mm, 6), []).append(hole)
    return tuple(
        same[0]
        if len(same) == 1
        else Hole(same[0].diameter_mm, sum(h.count for h in same), "; ".join(f"{h.count}x {h.callout}" for h in same))
        for same in groups.values()
    )
