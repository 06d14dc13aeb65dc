"""A tolerance chain: a figure of the assembled machine, what each tolerance does to it, and what it may be."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, inf, sqrt
from typing import Literal

Kind = Literal["stated", "place", "fit", "general", "bought", "set"]
"""Where a deviation comes from: a tolerance of a length or form that a drawing states, a place of a bore, play of a
fit, the general tolerances, a bought part, or what is set when the machine is put together."""
MADE: tuple[Kind, ...] = ("stated", "place", "general")
"""What a shop is asked for beside fits, and could be asked less of."""


@dataclass(frozen=True)
class Link:
    """What one part, or one step of the assembly, adds to a chain.

    Attributes:
        part: Part number.
        what: Which of its dimensions.
        kind: Where the deviation comes from.
        lower_mm: Least deviation of the dimension from its nominal value.
        upper_mm: Largest.
        share: By which the figure grows per mm of the dimension, either sign.
        nominal_mm: The dimension, 0 where a grade has no meaning.
    """

    part: str
    what: str
    kind: Kind
    lower_mm: float
    upper_mm: float
    share: float = 1.0
    nominal_mm: float = 0.0

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest of what it adds to the figure."""
        ends = self.share * self.lower_mm, self.share * self.upper_mm
        return min(ends), max(ends)

    @property
    def half(self) -> float:
        """Half of what it may change the figure by."""
        low, high = self.range
        return (high - low) / 2.0


def either_way(part: str, what: str, kind: Kind, by_mm: float, share: float = 1.0, nominal_mm: float = 0.0) -> Link:
    """Makes a link whose deviation is the same either way."""
    return Link(part, what, kind, -by_mm, by_mm, share, nominal_mm)


@dataclass(frozen=True)
class Chain:
    """One figure.

    Attributes:
        name: What it is, a few words.
        unit: Of figure and bounds.
        nominal: The figure where every dimension has its nominal value.
        links: What adds to it.
        low: Least that it may be; -inf where it has no bound.
        high: Largest that it may be.
        why: What happens beyond.
        statistical: Whether the root of the sum of squares decides: beyond the bound something cheap is made once more.
            Else the worst case does.
    """

    name: str
    unit: str
    nominal: float
    links: tuple[Link, ...]
    low: float
    high: float
    why: str
    statistical: bool = False

    @property
    def worst(self) -> tuple[float, float]:
        """Least and largest figure of any machine whose parts are all within their tolerances."""
        ends = [link.range for link in self.links]
        return self.nominal + sum(low for low, _ in ends), self.nominal + sum(high for _, high in ends)

    @property
    def rss(self) -> tuple[float, float]:
        """Range of 99.73 % of machines: each deviation normal about its zone's middle, half of it 3 sigmas."""
        low, high = self.worst
        middle, wide = (low + high) / 2.0, hypot(*(link.half for link in self.links))
        return middle - wide, middle + wide

    @property
    def decides(self) -> tuple[float, float]:
        """The range that is held against the bounds."""
        return self.rss if self.statistical else self.worst

    @property
    def holds(self) -> bool:
        """Whether every machine, or 99.73 % of them, is within the bounds."""
        low, high = self.decides
        return self.low <= low and high <= self.high

    @property
    def room(self) -> float:
        """Least distance from the range that decides to a bound, negative beyond it."""
        low, high = self.decides
        return min(low - self.low, self.high - high)

    def largest_mm(self, link: Link) -> float:
        """Computes how far a link's dimension may be off either way, the others as they are, mm; 0: not at all."""
        if not link.share:
            return inf
        return self._loosened({id(link)}) * link.half / abs(link.share)

    def looser(self) -> float:
        """Computes by which factor all that is `MADE` may be off more than it is, together; inf where nothing is."""
        return self._loosened({id(link) for link in self.links if link.kind in MADE})

    def _loosened(self, which: set[int]) -> float:
        """The factor on the halves of some links, the middles of their zones kept, with which the chain just holds."""
        low, high = self.worst
        middle = (low + high) / 2.0
        room = min(middle - self.low, self.high - middle)  # for the range's half
        own = [link.half for link in self.links if id(link) in which]
        rest = [link.half for link in self.links if id(link) not in which]
        if not any(own) or room == inf:
            return inf
        if not self.statistical:
            return max((room - sum(rest)) / sum(own), 0.0)
        return sqrt(max(room**2 - hypot(*rest) ** 2, 0.0)) / hypot(*own) if room > 0.0 else 0.0
