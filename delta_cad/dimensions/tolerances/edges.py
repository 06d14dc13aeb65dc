"""Edges that have a function: the general break of edges does not hold for them, each has limits of its own.

A broken edge is short of the sharp corner, a fillet or burr goes beyond it: ISO 13715, negative and positive.
"""

from __future__ import annotations

from dataclasses import dataclass

from delta_cad.dimensions import Dimensions

RIM_EDGE_MM = 0.02  # by which the rim of a ball's hole may be broken: it seats the ball on its stud's shoulder
STUD_CORNER_MM = 0.02  # fillet between a stud's pin and its shoulder: less than the bond beside the pin
RING_EDGE_MM = 0.1  # by which edges of a face on a bearing's inner ring may be broken: the face is narrow
LAND_EDGE_MM = 0.05  # by which edges of the lands between a pinion's turns may be: wider, nothing is left of them


@dataclass(frozen=True)
class Edge:
    """An edge with limits of its own.

    Attributes:
        what: Where it is.
        lower_mm: Largest break, negative.
        upper_mm: Largest fillet or burr.
        why: What it does.
    """

    what: str
    lower_mm: float
    upper_mm: float
    why: str

    @property
    def text(self) -> str:
        """As a drawing states it, for itself and not by the title block."""
        limits = "/".join(f"{v:+g}" if v else "0" for v in (self.upper_mm, self.lower_mm))
        return f"Edge ISO 13715 {limits}, not as the title block has it: {self.what}, {self.why}"


def functional_edges(d: Dimensions) -> dict[str, tuple[Edge, ...]]:
    """Lists by part number the edges that have a function."""
    on_ring = "on the bearing's inner ring"
    face = Edge("both edges of the collar's end face and its bore's there", -RING_EDGE_MM, 0.0, f"it stands {on_ring}")
    found = {
        "joint_ball": (Edge("rim of the hole", -RIM_EDGE_MM, 0.0, "it seats the ball on its stud's shoulder"),),
        "cross_bar": (
            Edge("corner of pin and shoulder, or an undercut", 0.0, STUD_CORNER_MM, "a ball's sharp rim stands there"),
        ),
    }
    if d.capstan is not None:
        washer = Edge("both edges of either face", -RING_EDGE_MM, 0.0, f"it presses {on_ring}")
        lands = Edge("lands between the turns of the groove", -LAND_EDGE_MM, 0.0, "the cable lies between them")
        found |= {"upper_arm": (face,), "sector": (face,), "pinion": (lands,)}
        if d.shaft.washer is None:
            found["shoulder_washer"] = (washer,)
    return found
