"""The loops that the project runs: the paper's, and the one on a board that bears a good wall, the default.

What decides a wall is `K (T / 2 + delay + lag)`, the damping that it takes: the board's loop is eight times as fast,
its currents four times, its velocity filter three, and it damps in the drive and in the law. Importing this module is
light.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

LINK_DELAYS = (0.5, 1.0, 1.5)  # Of a loop through a link, from reading to torque, periods


@dataclass(frozen=True)
class LoopChoice:
    """A sampled loop and its damping.

    Attributes:
        name: What it is called.
        period: T, s.
        delays: From reading to torque, least, nominal, largest, periods; the age of a reading comes on top.
        current_lag: Time constant of the current loop, s.
        corner: Of the low-pass on the joint rates, Hz.
        damping: Damping that every wall gets, N s/m at the handle.
        blend: Depth over which a wall's damping fades in, m: what it bears without is little.
        drive_damping: Physical damping of a motor by its amplifier, as a share of its short-circuit damping.
        contact_damping: The same while a wall is touched. Beside a spring that is sampled a switched damper is passive
            as far as that spring is: see `tests/haptics/simulation/test_contact.py`.
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
        """The same loop for what is felt where no wall is touched, or that no drive is told of."""
        return replace(self, contact_damping=self.drive_damping)

    @property
    def linked(self) -> LoopChoice:
        """The same loop closed by a host: a board applies a COMMAND at the tick after its STATE, a period late."""
        return replace(self, delays=LINK_DELAYS)


# What the paper states is 1 kHz; the rest of it are our assumptions: half a period of delay, a current loop of 0.8 kHz.
PAPER = LoopChoice("paper", 1e-3, (0.0, 0.5, 1.0), 0.2e-3, 100.0, 0.0, 0.5e-3, 0.0, 0.0)
# Law, velocity and current loop on one board. Half a period of delay: read, compute, write at once. A current loop of 3
# kHz has 1 / (2 pi 3000) = 0.053 ms. What noise moves on the structure as it is built decides the rest: encoders filter
# at a quarter of their bandwidth, and at a wall drives damp by 0.62 of the short circuit's, which no noise comes
# through, so that the law damps little. The tenth that is left elsewhere steadies springs and home, and drags by
# up to 0.45 N at 0.2 m/s: along z in the floor's middle.
# A velocity filter of 500 Hz lets a spring damp more than 300 with encoders as makers set them.
BOARD = LoopChoice("board", 1.25e-4, (0.25, 0.5, 0.75), 0.053e-3, 500.0, 0.17, 0.02e-3, 0.1, 0.62, 0.25)
RATES_Hz = (1000.0, 2000.0, 4000.0, 8000.0)  # Side by side: what a faster loop buys


def at_rate(rate_Hz: float, loop: LoopChoice = BOARD) -> LoopChoice:
    """The same loop at another rate: current loop, filter and damping stay, the delay stays in periods."""
    return replace(loop, name=f"{rate_Hz / 1e3:g} kHz", period=1.0 / rate_Hz)
