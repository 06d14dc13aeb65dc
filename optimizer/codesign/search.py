"""The search over hardware and lengths: candidates in closed form, then builds, until one passes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import product
from math import log
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

import numpy as np

from delta_cad.checks.report import CheckResult
from delta_cad.design import Design, DesignError, design_hash
from delta_cad.dimensions import DimensionError
from delta_cad.mechanism import MechanismError
from delta_cad.solids.primitive import BuildError
from optimizer.codesign import search_log
from optimizer.codesign.bound import excluded, impossible
from optimizer.codesign.candidate import (
    Candidate,
    ball_joint_friction,
    design_for,
    first_corrections,
    moment_torque_N_m,
    refused,
    reported,
    weigh,
    with_gravity_torque,
)
from optimizer.codesign.corrections import Corrections, MassEstimate, RaisedLimits
from optimizer.codesign.hardware import (
    SMALL,
    Selection,
    cheapest,
    dominated,
    drives,
    first_ratios,
    neighbours,
    unlikely,
    widths_of,
)
from optimizer.codesign.lengths import (
    ROUGHLY,
    ROUNDS,
    Found,
    as_good,
    best_lengths,
    is_better,
    tied_by_mass,
    worth_placing,
)
from optimizer.codesign.search_log import Phase, SearchLog, Trial, unmemoized, worded
from optimizer.codesign.updates import (
    COUPLE_STEP,
    ELBOW_STEP_DEG,
    LEVER_STEPS,
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
    with_reach,
    with_room,
)
from optimizer.problem.brief import DesignBrief
from optimizer.problem.variables import is_symmetric
from optimizer.search.clock import HalfTimeError, OutOfTimeError

if TYPE_CHECKING:
    from delta_cad.commands.pipeline import Outcome

HOPE = 0.05  # share by which hardware may exceed its estimate when it is refined
_COARSE, _AGAIN, _FINE = range(SMALL), range(1, SMALL), range(SMALL, SMALL + 3)  # how often steps are halved
_REFINED = 2  # times at most that hardware is refined with the masses of its solids
_WORSE = 0.01  # share of a score that solids took, beyond which hardware is refined again
RANKED, MOTORS = 6, 3  # motors whose parts are looked at, and that are refined and built, the likeliest first
_SWEEPS, _TRIES = 10, 24  # machines of one choice that are made; closed forms and weights, until they agree
_NO_LENGTHS = "no lengths meet the limits with its torque, masses and rods' springs"
_OWN_MASSES = "no lengths meet the limits with the masses and friction of its own parts"
LEAST_SIDE_MM, _ROOMY_MM = 10.0, 0.5  # of a cube where none is asked; of an outline, left: worth other lengths

T = TypeVar("T")
Lengths = tuple[float, ...]
"""(9) in the order of `VARIABLES`, mm."""
SolidResults = tuple[MassEstimate, list[CheckResult], tuple[float, float]]
"""Masses of the solids, the checks that these decide, and the friction of the ball joints, N."""


def _builds_nothing(_: Design) -> NoReturn:
    raise AssertionError


@dataclass
class Search:
    """One run: from what each motor may do to machines that are built, until one passes every check.

    Attributes:
        brief: What the customer asks.
        build: (design) -> what came of it.
        moving: (design) -> the checks of what moves.
        seed: Of everything random.
        stop: True ends the search: no step begins any more.
        hurried: True skips refinement and builds the current candidate: nothing passed yet, half of the time is over.
        report, tell: Take what is being done, and what was found.
        built_candidate: The candidate that the last `build` is of.
        memoize: Keeps what lengths and weights came to, as `Journal.memoize` does.
        dearer: Price of the machine that passed last over its estimate, where prices are compared.
        finely: Whether ratio, pinion and width are improved before a machine is built, beyond what passes.
        ready: A candidate that closed forms and its weights pass, which is built where the time is short.
        symmetric: Hardware with placed chains -> the three-fold symmetric candidate before, and what was known of it.
        phase: Where the search is.
        weightless: Whether it begins with `Corrections.weightless`.
    """

    brief: DesignBrief
    build: Callable[[Design], Outcome] = _builds_nothing
    moving: Callable[[Design], list[CheckResult]] = _builds_nothing
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
    symmetric: dict[tuple[str, str], tuple[Candidate, Corrections]] = field(default_factory=dict)
    phase: Phase = search_log.ESTIMATES
    weightless: bool = False

    def begin(self, step: str) -> None:
        """Reports a step; raises OutOfTimeError or HalfTimeError where there is no time for it."""
        self._require_time()
        self.report(self.phase.step(step, self.log, self.brief.objective, self.ready and self.ready.score))

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
        built = self.corrections.get(key) or self._first_corrections(choice)
        corrections = built.with_raised_limits(raised)
        geared = choice.drive == "capstan" and "capstan_ratio" not in self.brief.hardware
        roomy = False  # whether an outline was found to have room
        for _ in range(_TRIES):
            self.log.candidates += 1
            found = self._lengths(choice, corrections, start, ROUNDS if weighing else 1, beats)
            if found is None:
                raise NoProgressError(_OWN_MASSES if corrections.mass_estimate.own else _NO_LENGTHS)
            if beats is not None and found.score <= beats:
                return None
            start = lengths = found.lengths_mm
            try:
                design = design_for(self.brief, choice, lengths, corrections.at_arm_length(lengths[0]))
                if choice.placed and (known := with_reach(choice, corrections, design)) is not corrections:
                    corrections = known
                    continue
                reasons = refused(design)
                if geared and (pulled := [one for one in reasons if one.part == PULLED]):
                    torque = moment_torque_N_m(self.brief, lengths, 0.0)
                    corrections = from_cable_pull(corrections, design, torque, utilisation(pulled[0]))
                    reasons = tuple(one for one in reasons if one not in pulled)
                    if not reasons:
                        continue
                if reasons:
                    choice, corrections = from_refusals(self.brief, choice, corrections, reasons, lengths)
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
            near = corrections.mass_estimate.is_of(lengths[0], lengths[1], choice.ratio)
            self.begin(f"{candidate.side_mm:.2f} mm with {choice.motor} at {choice.ratio:g}:1: weighing")
            try:
                weighed, results, friction = self._weighed(design)
            except (BuildError, DimensionError) as error:  # what the kernel, or a stock length, does not give
                corrections = from_kernel(corrections, lengths, error)
                continue
            corrections = corrections.updated("weighed", mass_estimate=weighed, ball_friction_N=friction)
            candidate = replace(candidate, corrections=corrections, weighed=True)
            when = "" if self.brief.requirements.peak_force_N is None else ", peak"
            if geared and (pull := next((r for r in results if r.name == f"structure {PULLED}{when}"), None)):
                torque = moment_torque_N_m(self.brief, lengths, weighed.gravity_torque_N_m)
                corrections = from_cable_pull(corrections, design, torque, utilisation(pull))
            if near and all(result.passed for result in results):
                closer = with_outline(candidate, corrections, results)
                before, after = (one.beyond_mm(choice.placed) for one in (corrections, closer))
                spares = [a - b for a, b in zip(before, after, strict=True)]
                corrections, left = with_room(candidate, closer, results)
                if roomy or max(*spares, left) < _ROOMY_MM:
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
        raise InconclusiveError(f"lengths and masses did not converge in {_TRIES} steps")

    def _weighed(self, design: Design) -> SolidResults:
        """Masses and ball joint friction of a design; raises as `weigh`."""
        return self.memoize(
            "weighed",
            design_hash(design),
            lambda: (*weigh(design, lambda step: self.begin(f"weighing: {step}")), ball_joint_friction(design)),
            SolidResults,
        )

    def best(self) -> tuple[Candidate, Outcome] | None:
        """Searches until no hardware is left that promises more than the best machine that passed every check.

        Where none is found, hardware without lengths is searched once more from weightless parts. Raises OutOfTimeError
        where the time is over; what was built was handed to `build`.
        """
        if (found := self._best()) is None and not self.log.impossible and self._offered(anew=True):
            self.corrections, self.symmetric, self.weightless = {}, {}, True
            try:
                return self._best()
            finally:
                self.weightless = False
        return found

    def _offered(self, anew: bool) -> list[tuple[str, str]]:
        """Motors and drives that may be used; anew: those of them that have no lengths."""
        return [one for one in drives(self.brief) if not anew or self.log.no_progress.get(" ".join(one)) == _NO_LENGTHS]

    def _best(self) -> tuple[Candidate, Outcome] | None:
        best: tuple[Candidate, Outcome] | None = None
        for number, (score, choice) in enumerate(self.ranked()):
            promised = self.dearer * (score + HOPE * abs(score))
            if best is not None and (number >= MOTORS or promised <= best[0].score):
                break
            self.phase = search_log.REFINEMENT
            refined = self._refined_in_time(choice)
            if refined is not None and (best is None or self.dearer * refined.score > best[0].score):
                best = self._built_or_symmetric(refined, -np.inf if best is None else best[0].score) or best
            self.log.ended(name := f"{choice.motor} {choice.drive}")
            if best is None and name not in self.log.no_progress:
                self.log.inconclusive.add(name)
        return best

    def _built_or_symmetric(self, refined: Candidate, least: float) -> tuple[Candidate, Outcome] | None:
        """As `built`; the three-fold symmetric machine where none with placed chains passes that still pays."""
        if not refined.choice.placed or (key := (refined.choice.motor, refined.choice.drive)) not in self.symmetric:
            return self.built(refined, least)
        symmetric, known = self.symmetric[key]
        found = self.built(refined, max(least, worth_placing(self.brief, symmetric)))
        if found is None:
            self.tell(f"{' '.join(key)}: no machine with placed chains passes and pays; building the symmetric one")
            self.corrections[key] = known
            found = self.built(symmetric, least)
        return found

    def _refined_in_time(self, choice: Selection) -> Candidate | None:
        """Improves hardware as long as there is time for it; then the best that was weighed."""
        self.ready = None
        try:
            refined = self.refined(choice)
            for _ in range(_REFINED):
                if refined is not None and not refined.weighed and self._worse(refined):
                    refined = self.refined(refined.choice, again=True, start=refined.lengths_mm)
        except HalfTimeError:
            refined = self.ready
        self.ready = None
        return refined

    def _worse(self, refined: Candidate) -> bool:
        """Whether what solids tell of hardware makes it so much worse that another ratio or width may be better."""
        least = refined.score - _WORSE * abs(refined.score)
        again = self.fixed_point(refined.choice, refined.lengths_mm, beats=least)
        self.ready = again or self.ready
        return again is None

    def ranked(self) -> Iterator[tuple[float, Selection]]:
        """The hardware worth building: of the best estimates what their parts leave, the best first, then the rest."""
        self.log.left = list(dict.fromkeys((*self.log.left, *map(" ".join, self._offered(self.weightless)))))
        if not self.weightless:
            self.log.impossible = list(impossible(self.brief)) or [*filter(None, [excluded(self.brief, self.stop)])]
        if self.log.impossible:
            return
        found: list[tuple[float, Selection]] = []
        rest = sorted(self._rough(), key=lambda one: -one[0])
        for number, (score, choice) in enumerate(rest[:RANKED]):
            if found and (self.hurried() or score + HOPE * abs(score) <= max(one for one, _ in found)):
                break
            self.phase = search_log.PARTS._replace(done=number, total=min(RANKED, number + len(rest)))
            self.begin(f"cube with the parts of {choice.motor}")
            del rest[0]
            if (fixed_point := self._fixed_point_near(choice, weighing=False)) is None:
                self.log.ended(f"{choice.motor} {choice.drive}")
            else:
                one = choice.with_(ratio=fixed_point.choice.ratio, placed=fixed_point.choice.placed)
                found.append((min(fixed_point.score, score), one))
        yield from sorted(found, key=lambda one: -one[0])
        yield from rest

    def _first_corrections(self, choice: Selection) -> Corrections:
        return first_corrections(self.brief, choice, self.weightless)

    def _rough(self) -> list[tuple[float, Selection]]:
        """Estimates what every motor can do at its best ratio, the likeliest first; no parts are looked at.

        Chains are placed for the outline where no motor does with three-fold symmetric ones.
        """
        return self._estimates(placed=False) or (self._estimates(placed=True) if self.brief.placeable else [])

    def _estimates(self, placed: bool) -> list[tuple[float, Selection]]:
        found: list[tuple[float, Selection]] = []
        failed: list[Selection] = []
        known: Lengths | None = None  # of another motor: a place to begin from
        entries = cheapest(self.brief) if self.brief.objective == "cost" else {}
        offered = sorted(self._offered(self.weightless), key=lambda one: unlikely(self.brief, one))
        for number, (motor, drive) in enumerate(offered):
            self.phase = search_log.ESTIMATES._replace(done=number, total=len(offered))
            if found and self.hurried():
                break
            ratios = first_ratios(self.brief, drive)
            best: tuple[float, Selection] | None = None
            for width in widths_of(self.brief)[: 1 if found else None]:  # a narrower one where nothing fits
                for ratio in ratios:
                    choice = Selection(motor, drive, ratio, width, entries, placed=placed)
                    if dominated(self.brief, choice, failed):
                        continue
                    estimate = self._estimate(choice, known)
                    if estimate is None:
                        failed.append(choice)
                        continue
                    known = estimate.lengths_mm
                    least = -np.inf if best is None else best[0] + ROUGHLY * tied_by_mass(self.brief) * abs(best[0])
                    if best is None or estimate.score > least:
                        best = estimate.score, choice
                if best is not None:
                    break
            name = f"{motor} {drive}"
            if best is None:
                self.log.no_progress[name] = _NO_LENGTHS
                self.log.ended(name)
            else:
                if self.log.no_progress.pop(name, "") and name not in self.log.left:
                    self.log.left.append(name)
                self.tell(f"{motor} {drive} at {best[1].ratio:g}:1: about {self._words(best[0])}")
                found.append(best)
        return found

    def _words(self, score: float) -> str:
        return worded(self.brief.objective, score)

    def _estimate(self, choice: Selection, start_mm: Lengths | None = None) -> Found | None:
        """The best lengths of a choice, of parts that nobody looked at; None where there are none."""
        self.log.candidates += 1
        self.begin(f"estimating {choice.motor} at {choice.ratio:g}:1, rods {choice.width_mm:g} mm apart")
        known = self.corrections.get((choice.motor, choice.drive))
        return self._lengths(choice, known or self._first_corrections(choice), start_mm, 1)

    def refined(self, choice: Selection, again: bool = False, start: Lengths | None = None) -> Candidate | None:
        """Improves ratio and width of a choice, one after the other, as far as closed forms tell, then the placement.

        Of one that was refined before, and whose solids changed its corrections, nearer choices are looked at.
        """
        best = self._fixed_point_near(choice, not again, start if choice.placed else None)
        if not again:
            self.ready = best
        if best is None or not self.finely:
            return best
        best = self._climbed(best, _AGAIN if again else _COARSE)
        return best if again else self._placed(best)

    def _placed(self, symmetric: Candidate) -> Candidate:
        """Places the chains of a candidate for the outline, where that pays or is asked for."""
        if not self.brief.placeable or symmetric.choice.placed:
            return symmetric
        choice, key = symmetric.choice.with_(placed=True), (symmetric.choice.motor, symmetric.choice.drive)
        known, given_up = dict(self.corrections), (dict(self.log.no_progress), set(self.log.inconclusive))
        self.begin(f"placing the chains for the outline; symmetric chains give {self._words(symmetric.score)}")
        self.ready = self.ready and symmetric  # which is refined, and stands whatever the time is
        found = self._weighed_again(self.fixed_point(choice, symmetric.lengths_mm))  # limits are learnt anew near by
        if found is not None:
            climbed = self._climbed(found, _AGAIN[1:])  # what drives take of the outline goes with the width
            found = found if climbed is found else self._weighed_again(found, climbed)
        placed, self.corrections = self.corrections, dict(known)
        even = self.fixed_point(symmetric.choice, symmetric.lengths_mm) or symmetric  # weighed, if its weights pass
        words = f"{self._words(found.score) if found else 'no lengths'} with placed chains"
        self.log.placed.append(f"{' '.join(key)}: {words}, {self._words(even.score)} with symmetric chains")
        self.tell(self.log.placed[-1])
        if found is None or is_symmetric(found.lengths_mm) or found.score <= worth_placing(self.brief, even):
            self.corrections, (self.log.no_progress, self.log.inconclusive) = known, given_up
            return symmetric
        self.corrections = placed
        self.symmetric[key] = even, known.get(key, self._first_corrections(choice))
        return found

    def _weighed_again(self, found: Candidate | None, other: Candidate | None = None) -> Candidate | None:
        """The better of a weighed candidate and of what its hardware, or another's, comes to from its own lengths."""
        if (near := other or found) is None or found is None:
            return found
        known, again = dict(self.corrections), self.fixed_point(near.choice, near.lengths_mm)
        if again is not None and again.score > found.score:
            return again
        self.corrections = known  # what another machine was taught is not this one's
        return found

    def _polished(self, candidate: Candidate) -> Candidate:
        """Improves ratio and pinion of a candidate by small steps with its solids' masses, and weighs it again."""
        known, self.ready = dict(self.corrections), candidate
        try:
            finer = self._climbed(candidate, _FINE)
            beats = as_good(self.brief, candidate.score)
            again = None if finer is candidate else self.fixed_point(finer.choice, finer.lengths_mm, beats=beats)
        except HalfTimeError:
            again = None
        self.ready = None
        if again is None:
            self.corrections = known  # what another machine was taught is not this one's
        return again or candidate

    def _climbed(self, best: Candidate, halvings: Iterable[int]) -> Candidate:
        """Goes on to hardware near by that is better, by steps that are halved so often, as long as there is some."""
        peak = best.score
        for halved in halvings:
            better: Candidate | None = best
            while better is not None:
                best, better = better, None
                for one in neighbours(self.brief, best.choice, halved):
                    now = better or best
                    found = self._adjacent(one, now, peak)
                    if found is not None and is_better(self.brief, found, now, peak):
                        better, peak = found, max(peak, found.score)
        return best

    def _adjacent(self, one: Selection, best: Candidate, peak: float) -> Candidate | None:
        """What closed forms leave of hardware near the best; None where that is worse, or no better without ties."""
        index, per_mm, elbow_deg = best.corrections.raised_limits
        raised = index - COUPLE_STEP, per_mm / LEVER_STEPS[0], elbow_deg - ELBOW_STEP_DEG
        beats = as_good(self.brief, peak) if tied_by_mass(self.brief) else best.score
        beats = None if self.brief.objective == "cost" else beats  # a price is none of lengths
        found = self.fixed_point(one, best.lengths_mm, raised, weighing=False, beats=beats)
        left = self._words(found.score) if found else "no better"
        self.begin(f"{one.ratio:g}:1, rods {one.width_mm:g} mm apart: {left}")
        return found

    def _fixed_point_near(self, choice: Selection, weighing: bool, start: Lengths | None = None) -> Candidate | None:
        """What `fixed_point` finds, first of the nearest ratios, then of placed chains, then of other widths."""
        ratios = {choice.ratio, *first_ratios(self.brief, choice.drive)}
        nearest = sorted(ratios, key=lambda ratio: abs(log(ratio / choice.ratio)))
        widths = dict.fromkeys((choice.width_mm, *widths_of(self.brief)))
        placements = dict.fromkeys((choice.placed, choice.placed or self.brief.placeable))
        for width, placed, ratio in product(widths, placements, nearest):
            one = choice.with_(ratio=ratio, placed=placed, width_mm=width)
            if (found := self.fixed_point(one, start, weighing=weighing)) is not None:
                return found
        return None

    def built(
        self, first: Candidate | Selection, least: float, start: Lengths | None = None
    ) -> tuple[Candidate, Outcome] | None:
        """Builds a machine, and again with what its checks taught, until it passes or is no better than `least`.

        Args:
            first: A candidate; where the time is short it is built without being weighed again. Or hardware.
            least: Score to beat.
            start: Lengths to begin from.
        """
        choice = first if isinstance(first, Selection) else first.choice
        return self._or_log(choice, lambda: self._built(first, choice, least, start))

    def _built(
        self, first: Candidate | Selection, choice: Selection, least: float, start: Lengths | None
    ) -> tuple[Candidate, Outcome] | None:
        """As `built`; raises where its checks teach nothing."""
        key = choice.motor, choice.drive
        candidate: Candidate | None = None
        if isinstance(first, Candidate) and choice.placed:
            start = first.lengths_mm
        for turn in range(_SWEEPS):
            if not turn and isinstance(first, Candidate) and first.weighed:
                candidate = first
            else:
                candidate = self.fixed_point(choice, candidate.lengths_mm if candidate else start)
            if candidate is not None and self.finely and not turn and not self.hurried():
                candidate = self._polished(candidate)
            if candidate is None or self.dearer * candidate.score <= least:
                return None
            choice = candidate.choice
            named = f"{candidate.side_mm:.2f} mm with {choice.motor} at {choice.ratio:g}:1"
            self.phase = search_log.BUILDING if self.finely else search_log.NEAREST
            self.begin(f"{named}: clearance and outline in motion")
            outcome = None
            try:  # most that fails fails here, in a quarter of the time
                results = self.moving(candidate.design)
            except BuildError as error:  # a solid that cannot be meshed
                raise InconclusiveError(str(error)) from error
            if all(result.passed for result in results):
                self.begin(f"{named}: building")
                self.built_candidate = candidate
                outcome = self.build(candidate.design)
                results = outcome.results
            failed = tuple(result.name for result in results if not result.passed)
            self.log.built.append((candidate.design, failed))
            self.log.trials.append(Trial(candidate.choice, candidate.score, failed))
            if outcome is not None and not failed:
                self.log.no_progress.pop(" ".join(key), None)  # of another ratio or width
                self.log.ended(" ".join(key))
                self.tell(f"{named} passes every check")
                if (value := reported(self.brief.objective, outcome)) is None:
                    return candidate, outcome
                if self.brief.objective == "cost":  # others are estimated with its solids, and as well as built
                    self.dearer = -value / candidate.score
                return replace(candidate, score=-value), outcome
            self.tell(f"{named} fails: {', '.join(failed)}")
            self.corrections[key] = from_checks(candidate, self.corrections[key], results)
        raise InconclusiveError(f"{_SWEEPS} machines were made, and each failed a check")
