"""The search over hardware and lengths: candidates in closed form, then machines that are built, until one passes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from delta_cad.checks.report import CheckResult
from delta_cad.design import Design, DesignError, design_hash
from delta_cad.dimensions import CLEARANCE_MOST_MM, DimensionError
from delta_cad.mechanism import MechanismError
from delta_cad.solids.primitive import BuildError
from optimizer.codesign.candidate import Candidate, design_for, hung, refused, reported, rubbed, weigh, worst_torque
from optimizer.codesign.choice import SMALL, WIDTHS, Choice, cheapest, drives, hopeless, motor_of, neighbours, ratios_of
from optimizer.codesign.exclusion import excluded
from optimizer.codesign.journal import at_once, found_read, found_told, weighed_read, weighed_told
from optimizer.codesign.learning import (
    COUPLE_STEP,
    ELBOW_STEP_DEG,
    LEVER_STEPS,
    PULLED,
    StuckError,
    borne_of,
    by_weight,
    from_checks,
    from_kernel,
    from_pull,
    from_reasons,
    from_stiffness,
    too_soft,
    with_outline,
    with_room,
)
from optimizer.codesign.lengths import ROUNDS, Found, best_lengths
from optimizer.codesign.lessons import TORQUE_SPARE, TORQUE_SPARE_N_M, WEIGHED_AGAIN, Held, Lessons, Weighed
from optimizer.codesign.tried import Posed, Tried
from optimizer.problem.brief import DesignBrief
from optimizer.problem.evaluator import VARIABLES

if TYPE_CHECKING:
    from delta_cad.commands.pipeline import Outcome

TRIES = 16  # closed forms and weights of one choice, until they agree
RATIO_COUNT = 3  # ratios that are estimated first
HOPE = 0.05  # share by which hardware may exceed its estimate when it is refined
COARSE, AGAIN, FINE = range(SMALL), range(1, SMALL), range(SMALL, SMALL + 3)  # how often steps are halved
REFINED = 2  # times at most that hardware is refined with what solids told
WORSE = 0.01  # share of a score that solids took, beyond which hardware is refined again
GAIN = 5e-4  # share below which a change is none
LEAST_SIDE_MM = 10.0  # of a cube, where none is asked
RANKED, MOTORS = 6, 3  # motors whose parts are looked at, and that are refined and built, the likeliest first
SWEEPS = 10  # machines of one choice that are made
ROOMY_MM = 0.5  # of an outline, left by a machine that passes: worth other lengths

T = TypeVar("T")
Lengths = tuple[float, ...]
"""(6) in the order of `VARIABLES`, mm."""


@dataclass
class Search:
    """One run.

    Attributes:
        brief: What the customer asks.
        build: (design) -> what came of it.
        moving: (design) -> the checks of what moves.
        first: Masses to begin from.
        seed: Of everything random.
        stop: True ends the search with the best so far.
        hurried: True builds what there is: nothing passed yet, and the time is short.
        report: Told what is being done.
        tell: Told what was found.
        standing: The candidate that the last `build` is of.
        once: Keeps what lengths and weights came to, as `Journal.once` does.
        dearer: Price of the machine that passed last over its estimate, where prices are compared.
        finely: Whether ratio, pinion and width are improved before a machine is built, beyond what passes.
    """

    brief: DesignBrief
    build: Callable[[Design], Outcome]
    moving: Callable[[Design], list[CheckResult]]
    first: Weighed
    seed: int = 0
    stop: Callable[[], bool] = bool
    hurried: Callable[[], bool] = bool
    report: Callable[[str], None] = lambda _: None
    tell: Callable[[str], None] = lambda _: None
    tried: Tried = field(default_factory=Tried)
    lessons: dict[tuple[str, str], Lessons] = field(default_factory=dict)
    standing: Candidate | None = None
    once: Callable[..., Any] = at_once
    dearer: float = 1.0
    finely: bool = True

    def best(self) -> tuple[Candidate, Outcome] | None:
        """Searches until no hardware is left that promises more than the best machine that passed every check.

        Returns:
            The machine with the largest cube that was built and passed; None where none did.
        """
        best: tuple[Candidate, Outcome] | None = None
        for score, choice in self.ranked():
            if self.stop() or (best is not None and self.dearer * (score + HOPE * abs(score)) <= best[0].score):
                break
            refined = self.refined(choice)
            for _ in range(REFINED):
                if refined is not None and self._worse(refined):
                    refined = self.refined(refined.choice, again=True)
            if refined is None or (best is not None and self.dearer * refined.score <= best[0].score):
                continue
            best = self.built(refined.choice, -np.inf if best is None else best[0].score) or best
        return best

    def _worse(self, refined: Candidate) -> bool:
        """Whether what solids tell of hardware makes it so much worse that another ratio or width may be better."""
        least = refined.score - WORSE * abs(refined.score)
        return not self.stop() and self.settled(refined.choice, refined.lengths_mm, beats=least) is None

    def ranked(self) -> list[tuple[float, Choice]]:
        """The hardware worth building, the likeliest first: of the best estimates, what their parts leave."""
        found: list[tuple[float, Choice]] = []
        if (asked := self.brief.requirements.clearance_min_mm) > CLEARANCE_MOST_MM:
            told = f"requirements.clearance_min_mm = {asked:g} must be at most {CLEARANCE_MOST_MM:g} mm in any machine"
            self.tried.stuck["all hardware"] = told
            return found
        for score, choice in sorted(self._rough(), key=lambda one: -one[0])[:RANKED]:
            if self.stop() or (found and score + HOPE * abs(score) <= max(one for one, _ in found)):
                break
            self.report(f"what the parts of {choice.motor} leave")
            if (settled := self._settled_near(choice, weighing=False)) is not None:
                found.append((min(settled.score, score), choice.with_(ratio=settled.choice.ratio)))
        return sorted(found, key=lambda one: -one[0])[:MOTORS]

    def _rough(self) -> list[tuple[float, Choice]]:
        """Estimates what every motor can do at its best ratio, the likeliest first; no parts are looked at."""
        found: list[tuple[float, Choice]] = []
        failed: list[Choice] = []
        known: Lengths | None = None  # of another motor: a place to begin from
        if told := excluded(self.brief, self.stop):
            self.tried.stuck["all hardware"] = told
            return found
        entries = cheapest(self.brief) if self.brief.objective == "cost" else {}
        for motor, drive in sorted(drives(self.brief), key=self._unlikely):
            ratios = self._first_ratios(drive)
            best: tuple[float, Choice] | None = None
            for width in self._widths()[: 1 if found else None]:  # a narrower one where nothing fits
                for ratio in ratios:
                    if self.stop():
                        break
                    choice = Choice(motor, drive, ratio, width, entries)
                    if hopeless(self.brief, choice, failed):
                        continue
                    estimate = self._estimate(choice, known)
                    if estimate is None:
                        failed.append(choice)
                        continue
                    known = estimate.lengths_mm
                    if best is None or estimate.score > best[0]:
                        best = estimate.score, choice
                if best is not None:
                    break
            if best is None:
                self.tried.stuck[f"{motor} {drive}"] = "its torque, masses and rods' springs leave no cube"
            else:
                self.tell(f"{motor} {drive} at {best[1].ratio:g}:1: about {self._words(best[0])}")
                found.append(best)
        return found

    def _unlikely(self, hardware: tuple[str, str]) -> float:
        """Orders motors so that the first has lengths, from which the others begin: the lightest or the strongest."""
        row = motor_of(self.brief, hardware[0])
        if self.brief.feel.effective_mass_max_kg is None:
            return -row.nominal_torque_N_m * self._ratios(hardware[1])[1]
        return row.rotor_inertia_kg_m2 * self._ratios(hardware[1])[0] ** 2

    def _ratios(self, drive: str) -> tuple[float, float]:
        return ratios_of(self.brief) if drive == "capstan" else (1.0, 1.0)

    def _first_ratios(self, drive: str) -> list[float]:
        """The ratios that are estimated."""
        low, high = self._ratios(drive)
        return np.geomspace(low, high, RATIO_COUNT + 2)[1:-1].round(2).tolist() if high > low else [low]

    def _widths(self) -> tuple[float, ...]:
        stated = self.brief.limits.parallelogram_width_mm
        return WIDTHS if stated is None else (stated,)

    def _words(self, score: float) -> str:
        """Says what a score is."""
        words = {"cube_side": f"{score:.2f} mm of cube", "cost": f"{-score:.0f} EUR"}
        words["effective_mass"] = f"{-score:.4g} kg felt"
        return words.get(self.brief.objective, f"{-score:.2f} mm of width and depth")

    def _estimate(self, choice: Choice, start_mm: Lengths | None = None) -> Found | None:
        """The best lengths of a choice, of parts that nobody looked at; None where there are none."""
        self.tried.candidates += 1
        self.report(f"estimating {choice.motor} at {choice.ratio:g}:1, {choice.width_mm:g} mm wide")
        lessons = self.lessons.get((choice.motor, choice.drive)) or self._first(choice)
        return self._lengths(choice, lessons, start_mm, 1)

    def _lengths(
        self, choice: Choice, lessons: Lessons, start_mm: Lengths | None, rounds: int, beats: float | None = None
    ) -> Found | None:
        """The best lengths of a choice with what is known of it; None where none are, or none beat a score."""

        def compute() -> Found | None:
            return best_lengths(self.brief, choice, lessons, start_mm, self.seed, rounds, beats)

        of = self.brief, choice, replace(lessons, why=()), start_mm, rounds, beats
        found = self.once("lengths", of, compute, found_told, found_read)
        if found is not None:
            self.tried.posed.append(Posed(choice, found.score))
        return found

    def _first(self, choice: Choice) -> Lessons:
        """What is known of a choice to begin with: the masses of another machine, with the rotor of its own motor."""
        row = motor_of(self.brief, choice.motor)
        masses = replace(self.first.masses, rotor_inertia=row.rotor_inertia_kg_m2 * choice.ratio**2)
        spare = max(TORQUE_SPARE_N_M, TORQUE_SPARE * choice.torque_N_m(row))
        return Lessons(replace(self.first, masses=masses, ratio=choice.ratio), spare_torque_N_m=spare)

    def refined(self, choice: Choice, again: bool = False) -> Candidate | None:
        """Improves ratio and width of a choice, one after the other, as far as closed forms tell.

        Args:
            choice: Hardware.
            again: Whether it was refined already, and solids told something new: nearer choices are looked at.
        """
        best = self._settled_near(choice, weighing=not again)
        return best if best is None or not self.finely else self._climbed(best, AGAIN if again else COARSE)

    def _polished(self, candidate: Candidate) -> Candidate:
        """Improves ratio and pinion of a candidate by small steps, with what its solids told; it is weighed again."""
        finer, known = self._climbed(candidate, FINE), dict(self.lessons)
        if finer is not candidate and not self.stop():
            again = self.settled(finer.choice, finer.lengths_mm, beats=candidate.score)
            if again is not None:
                return again
        self.lessons = known  # what another machine was taught is not this one's
        return candidate

    def _climbed(self, best: Candidate, halvings: Iterable[int]) -> Candidate:
        """Goes on to hardware near by that is better, by steps that are halved so often, as long as there is some."""
        for halved in halvings:
            better: Candidate | None = best
            while better is not None and not self.stop():
                best, better = better, None
                for one in neighbours(self.brief, best.choice, halved):
                    found = None if self.hurried() else self._beside(one, better or best)
                    if found is not None and found.score > (better or best).score + GAIN * abs(best.score):
                        better = found
        return best

    def _beside(self, one: Choice, best: Candidate) -> Candidate | None:
        """What closed forms leave of hardware near the best; None where that is no better."""
        index, per_mm, elbow_deg = best.lessons.held
        held = index - COUPLE_STEP, per_mm / LEVER_STEPS[0], elbow_deg - ELBOW_STEP_DEG
        beats = None if self.brief.objective == "cost" else best.score  # a price is none of lengths
        found = self.settled(one, best.lengths_mm, held, weighing=False, beats=beats)
        self.report(f"{one.ratio:g}:1, {one.width_mm:g} mm wide: {self._words(found.score) if found else 'none'}")
        return found

    def _settled_near(self, choice: Choice, weighing: bool) -> Candidate | None:
        """What `settled` finds, of the nearest of the first ratios where it finds nothing: its parts may do."""
        ratios = {choice.ratio, *self._first_ratios(choice.drive)}
        for ratio in sorted(ratios, key=lambda ratio: abs(np.log(ratio / choice.ratio))):
            if not self.stop() and (found := self.settled(choice.with_(ratio=ratio), weighing=weighing)) is not None:
                return found
        return None

    def built(self, choice: Choice, least: float, start: Lengths | None = None) -> tuple[Candidate, Outcome] | None:
        """Builds a choice, and again with what its checks taught, until it passes or is no better than `least`.

        What moves is looked at before the rest: most that fails fails there, in a quarter of the time. The first
        lengths begin from `start`.
        """
        return self._or_stuck(choice, lambda: self._built(choice, least, start))

    def _or_stuck(self, choice: Choice, find: Callable[[], T | None]) -> T | None:
        """What is found; None where nothing is, which `tried.stuck` explains."""
        try:
            return find()
        except StuckError as error:
            self.tried.stuck[f"{choice.motor} {choice.drive}"] = str(error)
            return None

    def _built(self, choice: Choice, least: float, start: Lengths | None) -> tuple[Candidate, Outcome] | None:
        """As `built`; raises where its checks teach nothing."""
        key = choice.motor, choice.drive
        candidate: Candidate | None = None
        for turn in range(SWEEPS):
            candidate = self.settled(choice, candidate.lengths_mm if candidate else start)
            candidate = self._polished(candidate) if candidate and self.finely and not turn else candidate
            if candidate is None or self.dearer * candidate.score <= least or self.stop():
                return None
            choice = candidate.choice
            named = f"{candidate.side_mm:.2f} mm with {choice.motor} at {choice.ratio:g}:1"
            self.report(f"{named}: what moves")
            outcome = None
            try:
                results = self.moving(candidate.design)
            except BuildError as error:  # a solid that cannot be meshed
                raise StuckError(str(error)) from error
            if all(result.passed for result in results):
                self.report(f"{named}: building")
                self.standing = candidate
                outcome = self.build(candidate.design)
                results = outcome.results
            failed = tuple(result.name for result in results if not result.passed)
            self.tried.built.append((candidate.design, failed))
            self.tried.posed.append(Posed(candidate.choice, candidate.score, failed))
            if outcome is not None and not failed:
                self.tried.stuck.pop(" ".join(key), None)  # of another ratio or width
                self.tell(f"{named} passes every check")
                return self._reported(candidate, outcome), outcome
            self.tell(f"{named} fails: {', '.join(failed)}")
            self.lessons[key] = from_checks(candidate, self.lessons[key], results)
        return None

    def _reported(self, candidate: Candidate, outcome: Outcome) -> Candidate:
        """A machine that passed with the score that is reported of it, where that is not the cube."""
        if (value := reported(self.brief.objective, outcome)) is None:
            return candidate
        if self.brief.objective == "cost":  # others are estimated with the machine's own solids, and as well as built
            self.dearer = -value / candidate.score
        return replace(candidate, score=-value)

    def settled(
        self,
        choice: Choice,
        start: Lengths | None = None,
        held: Held = (0.0, 0.0, 0.0),
        weighing: bool = True,
        beats: float | None = None,
    ) -> Candidate | None:
        """Finds the best lengths of a choice that closed forms pass, with the masses of its own solids.

        Args:
            choice: Hardware.
            start: Lengths to begin from.
            held: To begin from: near by closed forms asked for it.
            weighing: Whether solids are made where the masses known are of another machine.
            beats: A score: a candidate that is no better need not be found.

        Returns:
            The candidate; None where there is none, which `tried.stuck` explains, or none that beats the score.
        """
        return self._or_stuck(choice, lambda: self._settled(choice, start, held, weighing, beats))

    def _settled(
        self, choice: Choice, start: Lengths | None, held: Held, weighing: bool, beats: float | None
    ) -> Candidate | None:
        """As `settled`; raises where there is no candidate, and says why."""
        key = choice.motor, choice.drive
        built = self.lessons.get(key) or self._first(choice)
        lessons = built.holding(held)
        geared = choice.drive == "capstan" and "capstan_ratio" not in self.brief.hardware
        roomy = False  # whether an outline was found to have room
        for _ in range(TRIES):
            self.tried.candidates += 1
            found = self._lengths(choice, lessons, start, ROUNDS if weighing else 1, beats)
            if found is None:
                raise StuckError("no lengths meet the limits with its torque, masses and rods' springs")
            if beats is not None and found.score <= beats:
                return None
            start = lengths = found.lengths_mm
            try:
                design = design_for(self.brief, choice, lengths, lessons.hanging(lengths[0]))
                reasons = refused(design)
                if geared and (pulled := [one for one in reasons if one.part == PULLED]):
                    bare = replace(lessons, weighed=replace(lessons.weighed, gravity_torque_N_m=0.0))
                    sector = design.hardware.sector_radius_mm
                    lessons = from_pull(lessons, sector, self._moment(bare, lengths), borne_of(pulled[0]))
                    reasons = tuple(one for one in reasons if one not in pulled)
                    if not reasons:
                        continue
                if reasons:
                    choice, lessons = from_reasons(self.brief, choice, lessons, reasons, found.side_mm)
                    continue
                if (soft := too_soft(design)) is not None:
                    lessons = from_stiffness(lessons, *soft, design)
                    continue
            except (DesignError, MechanismError) as error:
                raise StuckError(str(error)) from error
            candidate = Candidate(design, choice, lengths, lessons, found.score)
            if self.brief.requirements.cube_side_mm is None and candidate.side_mm < LEAST_SIDE_MM:
                raise StuckError(
                    f"it leaves a cube of {candidate.side_mm:.1f} mm; under {LEAST_SIDE_MM:g} is no answer"
                )
            if not weighing:
                return candidate
            if not lessons.weighed.own and (heavier := hung(design, lessons)) is not lessons:
                lessons = heavier
                continue
            near = self._known(lessons.weighed, lengths, choice)
            self.report(f"{candidate.side_mm:.2f} mm with {choice.motor} at {choice.ratio:g}:1: its masses")
            try:
                weighed, results, rubbing = self._weighed(design)
            except (BuildError, DimensionError) as error:  # what the kernel, or a stock length, does not give
                lessons = from_kernel(lessons, lengths, error)
                continue
            lessons = lessons.taught("weighed", weighed=weighed, ball_friction_N=rubbing)
            candidate = replace(candidate, lessons=lessons)
            when = "" if self.brief.requirements.peak_force_N is None else ", peak"
            if geared and (pull := next((r for r in results if r.name == f"structure {PULLED}{when}"), None)):
                sector = design.hardware.sector_radius_mm
                lessons = from_pull(lessons, sector, self._moment(lessons, lengths), borne_of(pull))
            if near and all(result.passed for result in results):
                closer = with_outline(candidate, lessons, results)
                spares = [a - b for a, b in zip(lessons.overhead_mm, closer.overhead_mm, strict=True)]
                lessons, left = with_room(candidate, closer, results)
                if roomy or max(*spares, left) < ROOMY_MM:
                    # what closed forms ask of this choice they do not ask of another
                    self.lessons[key] = built.with_shares_of(lessons)
                    return candidate
                roomy = True
                continue
            results = [result for result in results if not (geared and result.name.startswith(f"structure {PULLED}"))]
            if not near:  # what failed by its weight may do so no longer: that is known now
                results = [result for result in results if not by_weight(result.name)]
            lessons = from_checks(candidate, lessons, results)
            if lessons.crowded != built.crowded:  # of use to other widths, whatever comes of this one
                built = replace(built, crowded=lessons.crowded)
                self.lessons[key] = built
        raise StuckError("closed forms and weights did not come to agree")

    def _weighed(self, design: Design) -> tuple[Weighed, list[CheckResult], tuple[float, float]]:
        """Weighs a design, and what its ball joints rub with; raises as `weigh`."""
        return self.once(
            "weighed", design_hash(design), lambda: (*weigh(design), rubbed(design)), weighed_told, weighed_read
        )

    def _moment(self, lessons: Lessons, lengths: Lengths) -> float:
        """The most torque of a joint for a moment, N m."""
        force = self.brief.requirements.peak_force_N or self.brief.requirements.force_N
        return worst_torque(dict(zip(VARIABLES, lengths, strict=True)), force) + lessons.weighed.gravity_torque_N_m

    @staticmethod
    def _known(weighed: Weighed, lengths: tuple[float, ...], choice: Choice) -> bool:
        """Whether masses are those of a machine so near that another weighing would change nothing."""
        pairs = (weighed.upper_arm_mm, lengths[0]), (weighed.forearm_mm, lengths[1]), (weighed.ratio, choice.ratio)
        return weighed.own and all(abs(a - b) <= WEIGHED_AGAIN * b for a, b in pairs)
