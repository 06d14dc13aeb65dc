"""What each limit costs: the same lengths sought once more with one limit a little wider."""

from __future__ import annotations

from dataclasses import dataclass

from optimizer.codesign.candidate import Candidate
from optimizer.codesign.corrections import Corrections
from optimizer.codesign.lengths import CONVERGED, ENOUGH, best_lengths
from optimizer.problem.brief import DesignBrief

WIDER = {
    # table and field -> factor, and what is added
    "requirements.envelope_width_mm": (1.0, 5.0),
    "requirements.envelope_depth_mm": (1.0, 5.0),
    "requirements.force_N": (0.9, 0.0),
    "requirements.cube_side_mm": (0.95, 0.0),
    "feel.kappa_max": (1.05, 0.0),
    "feel.effective_mass_max_kg": (1.25, 0.0),
    "feel.couple_index_min": (0.9, 0.0),
    "limits.lean_max_deg": (1.0, 2.0),
    "limits.outline_radius_max_mm": (1.0, 2.0),
}
RESOLUTION = max(ENOUGH, CONVERGED)  # share of a score to which lengths are found


@dataclass(frozen=True)
class Cost:
    """What a limit costs.

    Attributes:
        field: Table and field of the requirements.
        asked: Its value.
        wider: Another, which is easier to keep.
        gain: By which what is sought would be better then; mm or kg.
    """

    field: str
    asked: float
    wider: float
    gain: float


def costs(brief: DesignBrief, candidate: Candidate, corrections: Corrections) -> list[Cost]:
    """Estimates what each stated limit costs, with the hardware of a machine and what was learnt of it.

    Args:
        brief: What the customer asks.
        candidate: The machine.
        corrections: What is known of it.

    Returns:
        The limits that cost more than the search resolves, the dearest first.
    """
    start = candidate.lengths_mm
    now = best_lengths(brief, candidate.choice, corrections, start)
    found: list[Cost] = []
    for field, (factor, added) in WIDER.items():
        asked = brief.value(field)
        if now is None or asked is None:
            continue
        wider = asked * factor + added
        better = best_lengths(brief.with_values({field: wider}), candidate.choice, corrections, start)
        if better is not None and better.score - now.score > RESOLUTION * abs(now.score):
            found.append(Cost(field, asked, wider, better.score - now.score))
    return sorted(found, key=lambda cost: -cost.gain)
