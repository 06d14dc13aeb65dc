"""What a limit is: thresholds on figures of merit, met by the design alone or at every point of its cube.

Each limit is one module beside this one: a class whose instances hold thresholds in SI units, with all that the rest
of the project needs of it. `delta_cad.mechanism.limits` lists them; inspection, checks, the optimizer's problem, the
global optimum, certificates, their replay and their report go through that list and name no limit themselves.
"""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import Enclosure
from delta_cad.mechanism.errors import GeometryError
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.limits.numbers import Masses, number, require, strict_radians

DEGREE = 180.0 / math.pi  # of a radian

Values = Mapping[str, Any]
"""Fields of a requirements file and their values; what is None is not required."""


@dataclass(frozen=True)
class Field:
    """A number that a requirements file may state for a limit.

    Attributes:
        name: With its unit, such as "lean_max_deg".
        description: What it is, for the file's schema.
        ge: It must be at least this.
        gt: It must be greater than this.
        le: It must be at most this.
        lt: It must be less than this.
    """

    name: str
    description: str
    ge: float | None = None
    gt: float | None = None
    le: float | None = None
    lt: float | None = None

    @property
    def bounds(self) -> dict[str, Any]:
        """Those of the four bounds that are given, by name."""
        found = {name: getattr(self, name) for name in ("ge", "gt", "le", "lt")}
        return {name: value for name, value in found.items() if value is not None}


@dataclass(frozen=True)
class FigureOfMerit:
    """A figure over the cube that a limit bounds, and how people see it.

    Attributes:
        name: Such as "shoulder_min".
        unit: People's unit; "" for none.
        values: (limit, mechanism, positions (..., 3) in m) -> (..., n) figures, one a chain or one; SI units.
        threshold: Attribute of the limit that bounds it; "" for a bound at 0.
        range: Smallest and largest threshold that the proof takes.
        upper: Whether the threshold is an upper one.
        relative: Whether a bound is sought at a share of the value, not at a distance in SI units.
        words: What a table calls it; the name with blanks where nothing is given.
    """

    name: str
    unit: str
    values: Callable[[Any, DeltaGeometry, np.ndarray], np.ndarray]
    threshold: str
    range: tuple[float, float]
    upper: bool = True
    relative: bool = True
    words: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "words", self.words or self.name.replace("_", " "))

    @property
    def scale(self) -> float:
        """SI unit to people's unit."""
        return {"mm": MM_PER_M, "deg": DEGREE}.get(self.unit, 1.0)

    @property
    def sense(self) -> str:
        """Sign of the inequality; a bound at 0 must not be reached."""
        return "<=" if self.upper else ">=" if self.threshold else ">"

    def worst(self, limit: Limit, g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
        """Computes the worst chain's figure.

        Args:
            limit: Whose other numbers (force, masses) count.
            g: The mechanism.
            p: (..., 3) positions, m.

        Returns:
            (...) SI units; NaN where a chain is open.
        """
        values = self.values(limit, g, p)
        return values.max(axis=-1) if self.upper else values.min(axis=-1)

    def stricter(self, a: float, b: float) -> float:
        """The stricter of two thresholds."""
        return min(a, b) if self.upper else max(a, b)


class DesignBounds(NamedTuple):
    """Bounds that a limit puts on the lengths alone, of three-fold symmetric designs with the cube on the axis.

    Attributes:
        reach_max_mm: Largest R + L_A.
        platform_radius_min_mm: Smallest r.
        forearm_per_half_side_min: Smallest L_B / L.
        level_elbow_min_mm: Least R + L_A - r: how far out of its wrist the elbow of a level upper arm is.
    """

    reach_max_mm: float = math.inf
    platform_radius_min_mm: float = 0.0
    forearm_per_half_side_min: float = 0.0
    level_elbow_min_mm: float = -math.inf

    def both(self, other: DesignBounds) -> DesignBounds:
        """The bounds of both."""
        return DesignBounds(
            min(self.reach_max_mm, other.reach_max_mm),
            max(self.platform_radius_min_mm, other.platform_radius_min_mm),
            max(self.forearm_per_half_side_min, other.forearm_per_half_side_min),
            max(self.level_elbow_min_mm, other.level_elbow_min_mm),
        )


@dataclass(frozen=True)
class Limit(ABC):
    """One limit; instances hold its thresholds as fields in SI units, each with its key in a certificate."""

    name: ClassVar[str]
    fields_: ClassVar[tuple[Field, ...]] = ()
    """What requirements files may state for it."""
    first_step: ClassVar[bool] = False
    """Whether the paper's first step has it."""
    of_every_design: ClassVar[bool] = False
    """Whether every design file is held to it, so that a search within bounds that can break it needs it, too."""
    evaluates: ClassVar[tuple[str, ...]] = ()
    """Dear figures of a search that its margin reads: "quality", "angles"."""
    keys: ClassVar[Mapping[str, str]] = {}
    """Attribute -> key with unit, as a certificate has it."""

    described: ClassVar[str] = ""
    """What is required, of a limit that no field states."""

    @classmethod
    def stated(cls, values: Values, strict: bool = False) -> Self | None:
        """Makes the limit that requirements state; None where they leave it out.

        Args:
            values: Fields of a requirements file.
            strict: Whether degrees become radians rounded to the strict side, as a certificate needs them.
        """
        del values, strict
        return cls()

    def describe(self, values: Values) -> str:
        """Says what is required, with the field that states it.

        Args:
            values: Fields of a requirements file.
        """
        del values
        return self.described

    def design_margin(self, lengths_mm: np.ndarray) -> np.ndarray | None:
        """Computes the margin of designs as a whole, where it has a closed form.

        Args:
            lengths_mm: (9, D) L_A, L_B, R_0, r, H, L, then where chains and cube stand: R_1 - R_0, the cosine of the
                azimuth of chain 1 (no mm), and x_c.

        Returns:
            (D,) without unit, not negative where the limit holds; None where positions decide.
        """
        del lengths_mm
        return None

    def smooth_margins(self, lengths_mm: np.ndarray) -> np.ndarray | None:
        """Computes smooth functions of the design whose least is `design_margin`, so that a descent sees no kink.

        Args:
            lengths_mm: As of `design_margin`.

        Returns:
            (parts, D) without unit; None where positions decide.
        """
        margin = self.design_margin(lengths_mm)
        return None if margin is None else margin[None]

    def design_bounds(self) -> DesignBounds:
        """Gives its bounds on the lengths of three-fold symmetric designs, rounded to the lax side."""
        return DesignBounds()


@dataclass(frozen=True)
class PoseLimit(Limit):
    """A limit on every position of the cube, which is proved for the continuum."""

    figures: ClassVar[tuple[FigureOfMerit, ...]]
    enclosure: ClassVar[Enclosure]
    """How it is proved over boxes of positions, and cut from boxes of designs."""
    strict: ClassVar[bool] = False
    """Whether its margin must be greater than 0, not only not less."""
    infinite_at_singularity: ClassVar[bool] = False
    """Whether its figures grow without bound towards a direct singularity."""
    needs: ClassVar[str] = ""
    """What must be known of the machine beside its lengths, as values have it: "inertia"; "" for nothing."""
    mass_kinds: ClassVar[Mapping[str, type[Masses]]] = {}
    """Attribute that holds masses -> their kind."""
    always: ClassVar[bool] = False
    """Whether it is part of every proof, because the others mean nothing without."""
    output_key: ClassVar[str] = ""
    """Key with unit of its figure's worst value in the output of a synthesis, in people's unit; "" for none."""

    def __post_init__(self) -> None:
        _require_ranges(self)

    @classmethod
    def measured(cls, values: Values) -> Self | None:
        """Makes an instance that bounds nothing, to measure its figures by; None where a number is missing.

        Args:
            values: Fields of a requirements file, and what else is known (force, masses).
        """
        known = cls.known(values)
        laxest = (f.range[1] if f.upper else f.range[0] for f in cls.figures if f.threshold)
        return None if known is None else cls(*laxest, *known)

    @classmethod
    def known(cls, values: Values) -> tuple[Any, ...] | None:
        """Reads what it `needs` of the machine, its attributes behind the thresholds; None where that is not known."""
        found = values.get(cls.needs) if cls.needs else ()
        return found if found is None or isinstance(found, tuple) else (found,)

    def numbers(self) -> tuple[float, ...]:
        """Gives the numbers that the compiled functions take, rounded ones with a bound of their error."""
        return ()

    def interval_margins(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes the margins once more in another arithmetic, for the replay of a certificate.

        Args:
            pose: The mechanism over boxes in interval slopes.
            exact: A double as an interval.

        Returns:
            Slope forms that are not negative where the limit holds.
        """
        del pose, exact
        raise TypeError(f"{self.name} proves itself again by `proved_by_intervals`, not by margins")

    def proved_by_intervals(self, pose: SlopePose, exact: Callable[[float], Interval]) -> np.ndarray:
        """Decides over which boxes the limit is proved in the other arithmetic, (n,)."""
        found = [margin.box.lo for margin in self.interval_margins(pose, exact)]
        return np.all([low > 0.0 if self.strict else low >= 0.0 for low in found], axis=0)

    def refuted_by_intervals(self, pose: SlopePose, exact: Callable[[float], Interval]) -> bool:
        """Decides whether a position, a box of no size, breaks the limit in exact arithmetic."""
        return any(bool(m.centre.hi[0] < 0.0) for m in self.interval_margins(pose, exact))

    def margin(self, f: Any) -> np.ndarray:
        """Computes the margin that a search sees: continuous, without unit.

        Args:
            f: Figures of D designs at K points, `optimizer.problem.evaluator.Figures`.

        Returns:
            (D, K) not negative where the limit holds.
        """
        del f
        raise TypeError(f"{self.name} holds for the cube in closed form: see `design_margin`")

    def search_quantities(self, f: Any) -> Mapping[str, np.ndarray]:
        """Computes continuous quantities whose minimum over the cube decides the worst value of its figure.

        Args:
            f: Figures of D designs at K points, `optimizer.problem.evaluator.Figures`.

        Returns:
            Name -> (D, K).
        """
        del f
        raise TypeError(f"{self.name} is not in the output of a synthesis: `output_key` is empty")

    def extreme_value(self, least: Mapping[str, float]) -> float:
        """Computes the worst value of its figure.

        Args:
            least: Name -> smallest value over the cube of what is sought.

        Returns:
            SI units; infinite where the figure grows without bound.
        """
        del least
        raise TypeError(f"{self.name} is not in the output of a synthesis: `output_key` is empty")

    def bound(self, figure: FigureOfMerit) -> float:
        """The threshold of one of its figures, SI units."""
        return float(getattr(self, figure.threshold)) if figure.threshold else 0.0

    def with_bound(self, figure: FigureOfMerit, value: float) -> Self:
        """The same with another threshold of one figure.

        Raises:
            GeometryError: The proof does not take it.
        """
        return replace(self, **{figure.threshold: value})

    def only(self, figure: FigureOfMerit) -> Self:
        """The same with its other figures left free."""
        alone = self
        for other in self.figures:
            if other is not figure:
                alone = alone.with_bound(other, other.range[1] if other.upper else other.range[0])
        return alone

    def less_strict_than(self, than: Any) -> bool:
        """Whether it is less strict than another of its kind, each number taken as exact."""
        return any(
            self.bound(f) > than.bound(f) if f.upper else self.bound(f) < than.bound(f)
            for f in self.figures
            if f.threshold
        )

    def broken(self, g: DeltaGeometry, point: np.ndarray) -> float:
        """Computes the worst figure at a position that breaks the limit, in plain double arithmetic.

        Args:
            g: The mechanism.
            point: (3,) position, m.

        Returns:
            SI units, of the figure that is farthest beyond its threshold; NaN where a chain is open.
        """
        worst = [(f, float(f.worst(self, g, point))) for f in self.figures]
        return max(worst, key=lambda one: (one[1] - self.bound(one[0])) * (1.0 if one[0].upper else -1.0))[1]

    def thresholds(self) -> float | tuple[float, ...]:
        """The threshold, or thresholds, as a finding holds them."""
        bounds = tuple(self.bound(f) for f in self.figures)
        return bounds[0] if len(bounds) == 1 else bounds

    def words(self, rounded: Callable[[float, bool], str]) -> str:
        """Says what is required, rounded so that the words are still true.

        Args:
            rounded: (value, upwards) -> text.
        """
        parts = []
        for f in self.figures:
            unit = f" {f.unit}" if f.unit else ""
            parts.append(f"{f.words} {f.sense} {rounded(self.bound(f) * f.scale, f.upper)}{unit}")
        return ", ".join(parts)

    def record(self) -> dict[str, Any]:
        """The limit as a certificate has it: key with unit -> number."""
        values = {key: getattr(self, name) for name, key in self.keys.items()}
        return {key: value.record() if isinstance(value, Masses) else value for key, value in values.items()}

    @classmethod
    def from_record(cls, data: Mapping[str, Any]) -> Self | None:
        """The limit of a certificate; None where it has none.

        Raises:
            GeometryError: A number that the proof does not take, or one of several that belong together is missing.
        """
        given = {name: data.get(key) for name, key in cls.keys.items()}
        missing = [name for name, value in given.items() if value is None]
        if missing:
            if len(missing) == len(given):
                return None
            raise GeometryError(f"{' and '.join(cls.keys.values())} belong together; one of them is missing")
        read = {name: cls.mass_kinds[name].from_record if name in cls.mass_kinds else number for name in given}
        return cls(**{name: read[name](cls.keys[name], value) for name, value in given.items()})


@dataclass(frozen=True)
class ThresholdLimit(PoseLimit):
    """A pose limit with one figure, whose threshold one field states in the figure's unit.

    The threshold is the first attribute; what the limit `needs` of the machine is behind it.
    """

    needed: ClassVar[str] = ""
    """What a user states where the machine is not known."""

    @classmethod
    def stated(cls, values: Values, strict: bool = False) -> Self | None:
        """Makes the limit where its field is given.

        Raises:
            GeometryError: What it needs of the machine is not known, or the proof does not take the threshold.
        """
        (field,), (figure,) = cls.fields_, cls.figures
        value, known = values.get(field.name), cls.known(values)
        if value is None:
            return None
        if known is None:
            raise GeometryError(f"{field.name} needs {cls.needed}")
        bound = value / figure.scale
        if figure.scale == DEGREE:
            inwards = -math.inf if figure.upper else math.inf
            bound = strict_radians(value, inwards) if strict else math.radians(value)
        numbers: tuple[Any, ...] = (bound, *known)
        return cls(*numbers)

    def describe(self, values: Values) -> str:
        """Says what is required, with the field that states it."""
        (field,) = self.fields_
        return f"limits.{field.name} = {values[field.name]}"


def _require_ranges(limit: PoseLimit) -> None:
    """Refuses thresholds out of the ranges that the proof takes, and what is not finite.

    Raises:
        GeometryError: The message names the attribute.
    """
    for f in limit.figures:
        if f.threshold:
            low, high = f.range
            value = getattr(limit, f.threshold)
            unit = {"mm": " m", "deg": " rad", "": ""}.get(f.unit, f" {f.unit}")
            require(f.threshold, value, low <= value <= high, f"within {low:g} and {high:g}{unit}")
    for field in fields(limit):
        value = getattr(limit, field.name)
        if isinstance(value, float):
            require(field.name, value, math.isfinite(value), "finite")
