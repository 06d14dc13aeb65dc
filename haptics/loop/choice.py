"""The loops of the project: that of a controller's board, the default, the same with drives that damp, the paper's.

What decides a wall is `K (T / 2 + delay + lag)`, the damping that it costs: the board loop is eight times as fast as
the paper's, its currents four times, its velocity filter five times. Importing this module is light.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from delta_cad.design import Design

_LINK_DELAYS = (0.5, 1.0, 1.5)  # Of a loop through a link, from reading to torque, periods


@dataclass(frozen=True)
class LoopChoice:
    """A sampled loop and its damping.

    Attributes:
        name: Its name without rate and damping; see `label`.
        period: T, s.
        delays: From reading to torque, least, nominal, largest, periods; the age of a reading comes on top.
        current_lag: Time constant of the current loop, s.
        corner: Of the low-pass on the joint rates, Hz.
        damping: Damping that every wall gets, N s/m at the handle.
        blend: Depth over which a wall's damping fades in, m: what it bears without is little.
        drive_damping: Physical damping of a motor by its amplifier, as a share of its short-circuit damping.
        contact_damping: The same while a wall is touched. Together with a spring that is sampled a switched damper is
            passive as far as that spring is: see `tests/haptics/loop/test_contact.py`.
        sensing: Bandwidth of the encoders' own filter, as a share of that with which their noise is stated; a power of
            two. Encoders without such a setting have 1.
    """

    name: str
    period: float
    delays: tuple[float, float, float]
    current_lag: float
    corner: float
    damping: float
    blend: float
    drive_damping: float
    contact_damping: float
    sensing: float = 1.0

    @property
    def delay(self) -> float:
        """The nominal delay, s."""
        return self.delays[1] * self.period

    @property
    def untouched(self) -> LoopChoice:
        """The same loop for what is felt where no wall is touched, or where no drive knows of the wall."""
        return replace(self, contact_damping=self.drive_damping)

    @property
    def linked(self) -> LoopChoice:
        """The same loop closed by a host: a board applies a COMMAND at the tick after its STATE, a period late."""
        return replace(self, delays=_LINK_DELAYS)

    @property
    def condition(self) -> str:
        """What the drives must do for its walls to stand."""
        if self.contact_damping == 0.0:
            return "drives add no damping"
        return f"drives damp without delay by {self.contact_damping:g} of the motors' short circuit at a wall"

    @property
    def label(self) -> str:
        """Name, rate, delay and damping, as every page has them."""
        return (
            f"{self.name} loop, {1e-3 / self.period:g} kHz, delay {1e3 * self.delay:.3g} ms, wall damping "
            f"{self.damping:g} N s/m, {self.condition}"
        )


# What the paper states is 1 kHz; the rest of it are our assumptions: half a period of delay, a current loop of 0.8 kHz.
PAPER = LoopChoice("paper", 1e-3, (0.0, 0.5, 1.0), 0.2e-3, 100.0, 0.0, 0.5e-3, 0.0, 0.0)
# Law, velocity and current loop on one board. Half a period of delay: read, compute, write at once. A current loop of 3
# kHz has 1 / (2 pi 3000) = 0.053 ms. Drives follow their current and add no damping, as amplifiers on sale; all of a
# wall's damping is computed. Encoders filter at a quarter of their bandwidth. A velocity filter of 500 Hz lets a spring
# damp more than 300 with encoders as makers set them.
BOARD = LoopChoice("board", 1.25e-4, (0.25, 0.5, 0.75), 0.053e-3, 500.0, 2.0, 0.02e-3, 0.0, 0.0, 0.25)
# The same with amplifiers whose inner loop damps at once, by 0.62 of the short circuit's while a wall is touched: no
# noise comes through it, so that the law damps little. A tenth elsewhere steadies springs and home, and drags by up to
# 0.45 N at 0.2 m/s: along z in the floor's middle. No amplifier on sale is known to do it.
_FREE_DAMPING = 0.1
DAMPED = replace(BOARD, name="damped", damping=0.17, drive_damping=_FREE_DAMPING, contact_damping=0.62)
RATES_Hz = (1000.0, 2000.0, 4000.0, 8000.0)  # Side by side: what a faster loop buys


def at_rate(rate_Hz: float, loop: LoopChoice = BOARD) -> LoopChoice:
    """The same loop at another rate: current loop, filter and damping stay, the delay stays in periods."""
    return replace(loop, period=1.0 / rate_Hz)


def chosen_loop(
    design: Design,
    rate_Hz: float | None = None,
    damping: float | None = None,
    drive_damping: float | None = None,
) -> LoopChoice:
    """The loop of a device: what is given, else what the design file says, else the board loop.

    Args:
        design: The design; its `loop` may be left out.
        rate_Hz: Ticks a second.
        damping: Of every wall, N s/m; with drives that damp that of `DAMPED` unless given.
        drive_damping: Share of the motors' short circuit at a wall; elsewhere at most `_FREE_DAMPING`.
    """
    file = design.loop
    rate = _first(rate_Hz, file and file.rate_Hz)
    drives = _first(drive_damping, file and file.drive_damping) or 0.0
    loop = BOARD
    if drives > 0.0:
        loop = replace(DAMPED, drive_damping=min(drives, _FREE_DAMPING), contact_damping=drives)
    loop = loop if rate is None else at_rate(rate, loop)
    own = _first(damping, file and file.damping_N_s_m)
    loop = loop if own is None else replace(loop, damping=own)
    if file is None or file.delay_ticks is None:
        return loop
    ticks = file.delay_ticks
    return replace(loop, delays=(0.5 * ticks, ticks, 1.5 * ticks))


def other_drives(loop: LoopChoice) -> LoopChoice:
    """The same loop with drives that damp where its own do not, and the other way round, to stand side by side."""
    other = DAMPED if loop.contact_damping == 0.0 else BOARD
    return replace(other, period=loop.period, delays=loop.delays)


def _first(*values: float | None) -> float | None:
    """The first value that is given."""
    return next((value for value in values if value is not None), None)
