"""Candidates of given hardware: lengths that closed forms pass, with the masses of their own solids."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeVar

from delta_cad.checks.report import CheckResult
from delta_cad.design import Design, DesignError, design_hash
from delta_cad.dimensions import DimensionError
from delta_cad.mechanism import MechanismError
from delta_cad.solids.primitive import BuildError
from optimizer.codesign.candidate import (
    Candidate,
    ball_joint_friction,
    design_for,
    refused,
    weigh,
    with_gravity_torque,
    worst_torque,
)
from optimizer.codesign.corrections import (
    TORQUE_SPARE,
    TORQUE_SPARE_N_M,
    WEIGHED_AGAIN,
    Corrections,
    MassEstimate,
    RaisedLimits,
)
from optimizer.codesign.hardware import Selection, motor_of
from optimizer.codesign.journal import unmemoized
from optimizer.codesign.lengths import ROUNDS, Found, best_lengths
from optimizer.codesign.search_log import SearchLog, Trial
from optimizer.codesign.updates import (
    PULLED,
    InconclusiveError,
    NoProgressError,
    by_weight,
    from_cable_pull,
    from_checks,
    from_kernel,
    from_refusals,
    from_stiffness,
    too_soft,
    utilisation,
    with_outline,
    with_room,
)
from optimizer.problem.brief import DesignBrief
from optimizer.problem.evaluator import VARIABLES
from optimizer.search.clock import HalfTimeError, OutOfTimeError

if TYPE_CHECKING:
    from delta_cad.commands.pipeline import Outcome

TRIES = 16  # closed forms and weights of one choice, until they agree
LEAST_SIDE_MM = 10.0  # of a cube, where none is asked
ROOMY_MM = 0.5  # of an outline, left by a machine that passes: worth other lengths

T = TypeVar("T")
Lengths = tuple[float, ...]
"""(6) in the order of `VARIABLES`, mm."""
SolidResults = tuple[MassEstimate, list[CheckResult], tuple[float, float]]
"""Masses of the solids, the checks that these decide, and the friction of the ball joints, N."""


@dataclass
class Candidates:
    """Candidates of a task: lengths that closed forms and weights pass, of given hardware.

    Attributes:
        brief: What the customer asks.
        build: (design) -> what came of it.
        moving: (design) -> the checks of what moves.
        first: Masses to begin from.
        seed: Of everything random.
        stop: True ends the search: no step begins any more.
        hurried: True builds what there is: nothing passed yet, and half of the time is over.
        report: Told what is being done.
        tell: Told what was found.
        built_candidate: The candidate that the last `build` is of.
        memoize: Keeps what lengths and weights came to, as `Journal.memoize` does.
        dearer: Price of the machine that passed last over its estimate, where prices are compared.
        finely: Whether ratio, pinion and width are improved before a machine is built, beyond what passes.
        ready: A candidate that closed forms and its weights pass, which is built where the time is short.
    """

    brief: DesignBrief
    build: Callable[[Design], Outcome]
    moving: Callable[[Design], list[CheckResult]]
    first: MassEstimate
    seed: int = 0
    stop: Callable[[], bool] = bool
    hurried: Callable[[], bool] = bool
    report: Callable[[str], None] = lambda _: None
    tell: Callable[[str], None] = lambda _: None
    log: SearchLog = field(default_factory=SearchLog)
    corrections: dict[tuple[str, str], Corrections] = field(default_factory=dict)
    built_candidate: Candidate | None = None
    memoize: Callable[..., Any] = unmemoized
    dearer: float = 1.0
    finely: bool = True
    ready: Candidate | None = None

    def begin(self, step: str) -> None:
        """Reports a step, or ends what goes on where there is no time for it.

        Args:
            step: What is being done.

        Raises:
            OutOfTimeError: The time is over.
            HalfTimeError: Half of it is over, and of the candidates that could be built none is.
        """
        self._require_time()
        self.report(step)

    def _require_time(self) -> None:
        if self.stop():
            raise OutOfTimeError
        if self.ready is not None and self.hurried():
            raise HalfTimeError

    def _lengths(
        self,
        choice: Selection,
        corrections: Corrections,
        start_mm: Lengths | None,
        rounds: int,
        beats: float | None = None,
    ) -> Found | None:
        """The best lengths of a choice with what is known of it; None where none are, or none beat a score."""

        def compute() -> Found | None:
            return best_lengths(self.brief, choice, corrections, start_mm, self.seed, rounds, beats, self._require_time)

        of = self.brief, choice, replace(corrections, why=()), start_mm, rounds, beats
        found = self.memoize("lengths", of, compute, Found | None)
        if found is not None:
            self.log.trials.append(Trial(choice, found.score))
        return found

    def _first(self, choice: Selection) -> Corrections:
        """What is known of a choice to begin with: the masses of another machine, with the rotor of its own motor."""
        row = motor_of(self.brief, choice.motor)
        masses = replace(self.first.masses, rotor_inertia=row.rotor_inertia_kg_m2 * choice.ratio**2)
        spare = max(TORQUE_SPARE_N_M, TORQUE_SPARE * choice.torque_N_m(row))
        return Corrections(replace(self.first, masses=masses, ratio=choice.ratio), spare_torque_N_m=spare)

    def _or_log(self, choice: Selection, find: Callable[[], T | None]) -> T | None:
        """What is found; None where nothing is, which `log.no_progress` explains."""
        try:
            return find()
        except NoProgressError as error:
            self.log.no_progress[f"{choice.motor} {choice.drive}"] = str(error)
            if isinstance(error, InconclusiveError):
                self.log.inconclusive.add(f"{choice.motor} {choice.drive}")
            return None

    def fixed_point(
        self,
        choice: Selection,
        start: Lengths | None = None,
        raised: RaisedLimits = (0.0, 0.0, 0.0),
        weighing: bool = True,
        beats: float | None = None,
    ) -> Candidate | None:
        """Finds the best lengths of a choice that closed forms pass, with the masses of its own solids.

        Args:
            choice: Hardware.
            start: Lengths to begin from.
            raised: To begin from: near by closed forms asked for it.
            weighing: Whether solids are made where the masses known are of another machine.
            beats: A score: a candidate that is no better need not be found.

        Returns:
            The candidate; None where there is none, which `log.no_progress` explains, or none that beats the score.
        """
        return self._or_log(choice, lambda: self._fixed_point(choice, start, raised, weighing, beats))

    def _fixed_point(
        self, choice: Selection, start: Lengths | None, raised: RaisedLimits, weighing: bool, beats: float | None
    ) -> Candidate | None:
        """As `fixed_point`; raises where there is no candidate, and says why."""
        key = choice.motor, choice.drive
        built = self.corrections.get(key) or self._first(choice)
        corrections = built.with_raised_limits(raised)
        geared = choice.drive == "capstan" and "capstan_ratio" not in self.brief.hardware
        roomy = False  # whether an outline was found to have room
        for _ in range(TRIES):
            self.log.candidates += 1
            found = self._lengths(choice, corrections, start, ROUNDS if weighing else 1, beats)
            if found is None:
                raise NoProgressError("no lengths meet the limits with its torque, masses and rods' springs")
            if beats is not None and found.score <= beats:
                return None
            start = lengths = found.lengths_mm
            try:
                design = design_for(self.brief, choice, lengths, corrections.at_arm_length(lengths[0]))
                reasons = refused(design)
                if geared and (pulled := [one for one in reasons if one.part == PULLED]):
                    bare = replace(
                        corrections, mass_estimate=replace(corrections.mass_estimate, gravity_torque_N_m=0.0)
                    )
                    sector = design.hardware.sector_radius_mm
                    corrections = from_cable_pull(
                        corrections, sector, self._moment(bare, lengths), utilisation(pulled[0])
                    )
                    reasons = tuple(one for one in reasons if one not in pulled)
                    if not reasons:
                        continue
                if reasons:
                    choice, corrections = from_refusals(self.brief, choice, corrections, reasons, found.side_mm)
                    continue
                if (soft := too_soft(design)) is not None:
                    corrections = from_stiffness(corrections, *soft, design)
                    continue
            except (DesignError, MechanismError) as error:
                raise InconclusiveError(str(error)) from error
            candidate = Candidate(design, choice, lengths, corrections, found.score)
            if self.brief.requirements.cube_side_mm is None and candidate.side_mm < LEAST_SIDE_MM:
                raise NoProgressError(
                    f"it leaves a cube of {candidate.side_mm:.1f} mm; under {LEAST_SIDE_MM:g} is no answer"
                )
            if not weighing:
                return candidate
            if (
                not corrections.mass_estimate.own
                and (heavier := with_gravity_torque(design, corrections)) is not corrections
            ):
                corrections = heavier
                continue
            near = self._known(corrections.mass_estimate, lengths, choice)
            self.begin(f"{candidate.side_mm:.2f} mm with {choice.motor} at {choice.ratio:g}:1: its masses")
            try:
                weighed, results, friction = self._weighed(design)
            except (BuildError, DimensionError) as error:  # what the kernel, or a stock length, does not give
                corrections = from_kernel(corrections, lengths, error)
                continue
            corrections = corrections.updated("weighed", mass_estimate=weighed, ball_friction_N=friction)
            candidate = replace(candidate, corrections=corrections, weighed=True)
            when = "" if self.brief.requirements.peak_force_N is None else ", peak"
            if geared and (pull := next((r for r in results if r.name == f"structure {PULLED}{when}"), None)):
                sector = design.hardware.sector_radius_mm
                corrections = from_cable_pull(
                    corrections, sector, self._moment(corrections, lengths), utilisation(pull)
                )
            if near and all(result.passed for result in results):
                closer = with_outline(candidate, corrections, results)
                spares = [a - b for a, b in zip(corrections.overhead_mm, closer.overhead_mm, strict=True)]
                corrections, left = with_room(candidate, closer, results)
                if roomy or max(*spares, left) < ROOMY_MM:
                    # what closed forms ask of this choice they do not ask of another
                    self.corrections[key] = built.with_shares_of(corrections)
                    return candidate
                roomy = True
                continue
            results = [result for result in results if not (geared and result.name.startswith(f"structure {PULLED}"))]
            if not near:  # what failed by its weight may do so no longer: that is known now
                results = [result for result in results if not by_weight(result.name)]
            corrections = from_checks(candidate, corrections, results)
            if corrections.interferences != built.interferences:  # of use to other widths, whatever comes of this one
                built = replace(built, interferences=corrections.interferences)
                self.corrections[key] = built
        raise InconclusiveError("closed forms and weights did not come to agree")

    def _weighed(self, design: Design) -> SolidResults:
        """Weighs a design, and what its ball joints rub with; raises as `weigh`."""
        return self.memoize(
            "weighed",
            design_hash(design),
            lambda: (*weigh(design, self.begin), ball_joint_friction(design)),
            SolidResults,
        )

    def _moment(self, corrections: Corrections, lengths: Lengths) -> float:
        """The most torque of a joint for a moment, N m."""
        force = self.brief.requirements.peak_force_N or self.brief.requirements.force_N
        return (
            worst_torque(dict(zip(VARIABLES, lengths, strict=True)), force)
            + corrections.mass_estimate.gravity_torque_N_m
        )

    @staticmethod
    def _known(weighed: MassEstimate, lengths: tuple[float, ...], choice: Selection) -> bool:
        """Whether masses are those of a machine so near that another weighing would change nothing."""
        pairs = (weighed.upper_arm_mm, lengths[0]), (weighed.forearm_mm, lengths[1]), (weighed.ratio, choice.ratio)
        return weighed.own and all(abs(a - b) <= WEIGHED_AGAIN * b for a, b in pairs)
