"""Every link of every chain by hand: deviation either way and share, from the standards' figures and the drawings'.

Zones of 0.05 mm count half to either side; a fit's play is half of what bore and shaft may be apart. The machine is the
one that the tests know, general class m. A link that is left out, counted twice or of the wrong sign changes its line.
"""

from __future__ import annotations

from math import acos, hypot, inf, isnan, nan, pi, sqrt, tan

import pytest

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.chain import Chain
from delta_cad.dimensions.tolerances.machine import deviation_mm, largest_deviation_mm, length_chains, machine_chains

Line = tuple[str, float | tuple[float, float], float]
"""What, deviation (either way, or least and largest) in mm, share."""

PLACE = 0.05 / 2.0  # of a bore in its zone
DOWEL = (0.010 - 0.002) / 2.0  # 3 m6 (2 to 8 um) in H7 (0 to 10 um)
SEAT = (0.018 + 0.008) / 2.0  # 16 H7 and a ring 8 um smaller
SEAT_H6 = (0.011 + 0.008) / 2.0
SHAFT = 0.009 / 2.0  # 8 h6
PILOT = (0.018 + 0.018) / 2.0  # 15 H7, 15 h7
BAR = 0.02 + (0.020 + 0.009) / 2.0  # a layer of 0.02, a bore 20 um wider, 8 h6
ARCMIN = 10_800.0 / pi

STACK: list[Line] = [
    ("depth of the seat", 0.02, 1.0),
    ("width", 0.02, 1.0),
    ("from the arm to its collar", 0.02, -1.0),
    ("from its collar to the sector", 0.02, -1.0),
    ("width, motor's side", (-0.12, 0.0), -1.0),
    ("width, encoder's side", (-0.12, 0.0), -1.0),
]
SHOULDER: list[Line] = [
    ("place of a dowel", PLACE, 1.0),
    ("dowels in the plate", DOWEL, 1.0),
    ("cross dowels from the upright ones", PLACE, 1.0),
    ("dowels in the block", DOWEL, 1.0),
    ("seat from its dowels", PLACE, 1.0),
    ("in its seat", SEAT, 1.0),
    ("in its bearing", SHAFT, 1.0),
]
# Pins 33 apart, 79.7 below the shoulder, which stands between them, each off by 0.025 in cheek and in block: the turn
# of both and the first one's own shift, the worst way, less that shift, which counts above. Upright it adds nothing.
LEVER = 79.7 / 33.0
TURNED: Line = ("turned by its dowels' places", 2 * PLACE * (sqrt(1.0 + LEVER**2) + LEVER) - 2 * PLACE, 1.0)
BALL: list[Line] = [
    ("in its bond", BAR, 1.0),
    ("studs off its middle", 0.05 / 2.0, 1.0),
    ("on its stud, in its bond", 0.025 + (0.010 + 0.020) / 2.0, 1.0),  # a layer of 0.025, 2.5 h7, 20 um of erosion
    ("hole off its centre", 0.05, 1.0),
]
WRIST: list[Line] = [("place of a bar's bore", PLACE, 1.0), *BALL]
AXES: list[Line] = [
    ("pilot from the bearing's seat", PLACE, 1.0),
    ("pilot in its cheek", PILOT, 1.0),
    ("in its seat", SEAT, 1.0),
    ("in its bearing", SHAFT, 1.0),
    ("on its shaft", (0.020 + 0.009) / 2.0, 1.0),  # 8 G7 (5 to 20 um), 8 h6
    ("on the motor's shaft", (0.012 + 0.008) / 2.0, 1.0),  # 5 H7, 5 h6
    ("groove off its bore", 0.05 / 2.0, 1.0),
]
# Two cones of the jig in zones of 0.05; seats of 6.015 +-0.005 on balls of 6
ROD: list[Line] = [("places of its cones", 2 * PLACE, 1.0), ("both seats on the jig's balls", 0.02, 1.0)]
TWIST = 180.0 / pi / 54.0  # deg per mm at rods 54 mm apart
# Both cheeks' mandrels, 8 um thinner, in seats of H7 and H6, 30 mm apart; dowels 33 mm apart, 79.7 mm below
TILT: list[Line] = [
    ("mandrel in its seat", (0.018 + 0.008) / 2.0, ARCMIN / 30.0),
    ("mandrel in its seat", (0.011 + 0.008) / 2.0, ARCMIN / 30.0),
    ("dowels lift it", DOWEL, ARCMIN / 30.0),
    ("dowels turn it", DOWEL, ARCMIN / 30.0 * 2.0 * 79.7 / 33.0),
    ("dowels lift it", DOWEL, ARCMIN / 30.0),
    ("dowels turn it", DOWEL, ARCMIN / 30.0 * 2.0 * 79.7 / 33.0),
]

# Crossed tangents of radii r and p, C apart: S = sqrt(C^2 - (r + p)^2) each, at acos((r + p) / C) from the line of
# centres; the cable is h (2 S + r turn + p (6 pi - 2 acos)) long, h the length of its climb.
R, P, C, TURN = 38.7, 8.0625, 47.7625, 2.092627358886441 + 2.0 * 0.10335917312661498
S = sqrt(C**2 - (R + P) ** 2)
CLIMB = 0.7 / (2.0 * pi * P)
H = hypot(1.0, CLIMB)
WAY = 2.0 * S + R * TURN + P * (6.0 * pi - 2.0 * acos((R + P) / C))
# The rim's ends stay on the sector: with t = acos((R + P) / C), d(2 S - 2 (R + P) t) = -2 t d(R + P) + 2 S / C dC
BY_SECTOR = H * TURN
BY_PINION = H * (6.0 * pi - 2.0 * acos((R + P) / C)) - CLIMB**2 / P / H * WAY
APART = H * 2.0 * S / C

HOLE = 2.5 / 2.0 + 0.025  # of a ball: pin and bond
SLOPE = HOLE / sqrt(3.0**2 - HOLE**2)
RIM = SLOPE * 0.020 / 2.0  # by which its rim moves, eroded 20 um wider or narrower
DEG = 180.0 / pi

CHAINS: dict[str, tuple[float, float, list[Line]]] = {  # name -> nominal, upper bound, links
    "wave spring's height": (1.2, 2.2 - 0.2 * (2.2 - 0.15), [*STACK, ("depth of the seat", 0.02, 1.0)]),
    "shaft's tilt": (0.0, 10.0, TILT),
    "bearing's tilt, motor's side": (
        0.0,
        10.0,
        [
            *TILT,
            ("seat out of square", 0.02 / 2.0, 2.0 * ARCMIN / 5.0),  # over the bearing's width
            ("turns in its seat by its play", (0.0, 0.018 + 0.008), -ARCMIN / 5.0),
        ],
    ),
    "bearing's tilt, encoder's side": (
        0.0,
        10.0,
        [
            *TILT,
            ("seat out of square", 0.04 / 2.0, 2.0 * ARCMIN / 14.4),  # the wave spring stands behind the bearing
            ("turns in its seat by its play", (0.0, 0.011 + 0.008), -ARCMIN / 5.0),
            ("shoulder out of square", 0.03 / 2.0, 2.0 * ARCMIN / 9.75),
        ],
    ),
    "encoder's air gap": (
        # chip 1.1 above its board, whose face is 24.4 mm out, magnet's end at 22.05
        24.4 - 22.05 - 1.1,
        2.0,
        [
            *STACK,
            ("length of its head", 0.1, -1.0),  # 4.85 mm
            ("thickness of its head", 0.2, 1.0),  # 15.4 mm
            ("length", 0.13, 1.0),  # 5 mm, a spacer from stock
            ("height of its chip", 0.25, -1.0),
            ("thickness", 0.1, -1.0),
            ("depth of the magnet's seat", 0.1, 1.0),  # 2.5 mm
        ],
    ),
    "encoder's centring": (
        0.0,
        0.3,
        [
            ("place of the board's threads", 0.2 / 2.0, 1.0),
            ("its screws in its holes", (2.9 - 2.5) / 2.0, 1.0),
            ("place of the chip", 0.1, 1.0),
            ("in its seat's bond", 0.05 + 0.030 / 2.0, 1.0),
            ("magnet's seat off its journal", 0.05 / 2.0, 1.0),
            ("in its seat", SEAT_H6, 1.0),
            ("in its bearing", SHAFT, 1.0),
            ("seat out of square", 0.04 / 2.0, (14.4 - 5.0) / 14.4),  # the bearing is at its end, 4.7 from its middle
        ],
    ),
    "cable's plane": (
        0.0,
        (S + R * 0.10335917312661498)
        * (tan(0.0436) - CLIMB),  # 2.5 deg over the strand to the rim's end, less its climb
        [
            ("place of a rim's end", 0.1, 1.0),  # 4.7 mm
            ("groove from its collar", 0.1, 1.0),  # 2.8 mm
            ("its collar set to the rim by a feeler", 0.1, 1.0),
            *((what, by, share * R / ARCMIN) for what, by, share in TILT),
            ("pilot out of square", 0.05 / 2.0, 2.0 * P / 4.6),  # over a cheek of 4.6 mm at the motor
            ("bore out of square", 0.05 / 2.0, 2.0 * R / 9.8),  # of the sector
            ("bore out of square", 0.012 / 2.0, 2.0 * R / 15.2),  # of the arm with its collar
        ],
    ),
    "gap of sector and pinion": (
        C - 38.43 - 7.9275,
        inf,
        [*AXES, ("radius of its rim", 0.05, -1.0), ("diameter of its crest", 0.02, -0.5)],
    ),
    "cheek off the plate": (
        0.5,
        inf,
        [
            ("lower edge from its dowels", 0.2, 1.0),  # 6.5 mm
            # the foot's corner is 4.5 beyond the first dowel of two 33 apart
            ("places of its dowels and the block's", 2 * PLACE * (1.0 + 2.0 * 4.5 / 33.0), 1.0),
            ("height of its cross dowels", PLACE, 1.0),
        ],
    ),
    "platform's twist": (
        0.0,
        3.0,
        [(f"{what}, rod {k}", by, sign * TWIST) for k, sign in ((1, 1.0), (2, -1.0)) for what, by, _ in ROD],
    ),
    "cup's turn in the jig": (
        DEG * 0.1 / 4.7075,
        3.0,
        # a lip 0.1 over its pad, 4.7075 from the rod's axis; a seat wider by twice that lets its ball as far down
        [("depth of its seats", 0.05, DEG / 4.7075), ("radius of its cones' mouths", 0.05 / 2.0, DEG / 4.7075)],
    ),
    "encoder's zero on its stop": (
        0.0,
        2.0,
        [
            # 19.5 mm from the shoulder
            ("place of its slot's end", 0.05, DEG / 19.5),
            ("width of its slot", 0.1 / 2.0, DEG / 19.5),
            ("in its seat", 0.018 / 2.0, DEG / 19.5),
            ("stop pin from the shoulder's axis", 0.05, DEG / 19.5),
            ("half of its thickness", (0.004 + 0.012) / 4.0, DEG / 19.5),
            ("bar's bore from the shaft's", PLACE, DEG / 91.0),
            # 7.5 mm from it
            *(("holes drilled for the dowels", 0.025, DEG / 7.5),) * 2,
            *(("pin in a drilled hole while they are reamed", 0.05, DEG / 7.5),) * 2,
        ],
    ),
    "base radius": (31.0, inf, [*SHOULDER, TURNED]),
    "shoulder's height": (
        0.0,
        inf,
        [*SHOULDER, ("turned by its dowels' places", 0.0, 1.0), ("flat under the feet", 0.4 / 2.0, 1.0)],  # K of 146 mm
    ),
    "shoulder along its axis": (
        0.0,
        inf,
        [
            ("bore out of square", 0.012 / 2.0, 2.0 * 91.0 / 15.2),
            ("place of a dowel", PLACE, 1.0),
            ("dowels in the plate", DOWEL, 1.0),
            ("dowels from its middle", PLACE, 1.0),
            ("width", 0.02, 0.5),
            ("depth of the seat", 0.02, 1.0),
            ("width, motor's side", (-0.12, 0.0), -1.0),
            ("from the arm to its collar", 0.02, -1.0),
        ],
    ),
    "upper arm": (
        91.0,
        inf,
        [
            ("bar's bore from the shaft's", PLACE, 1.0),
            ("on its shaft", (0.015 + 0.009) / 2.0, 1.0),  # 8 H7, 8 h6
            *BALL,
        ],
    ),
    "forearm": (143.196, inf, ROD),
    "platform radius": (24.0, inf, WRIST),
    "wrist's height": (0.0, inf, WRIST),
    "wrist along its axis": (
        0.0,
        inf,
        [
            ("set in its boss by a gauge", 0.05, 1.0),
            ("distance of its shoulders", 0.02, 0.5),
            ("rim of its hole, one end", RIM, 0.5),
            ("rim of its hole, other end", RIM, 0.5),
            ("edge of its hole, one end", (-0.02, 0.0), SLOPE / 2.0),
            ("edge of its hole, other end", (-0.02, 0.0), -SLOPE / 2.0),
        ],
    ),
    "encoder's zero": (0.0, 0.5, [("position anywhere in the cube", 0.1, nan)]),
    "carriage's travel": (
        nan,
        nan,
        [
            ("length between its sleeves", 1.0, 1.0),
            ("radius of its rim", 0.05, -BY_SECTOR),
            ("radius of its nose", 0.1, -pi / 2.0),  # a quarter turn round 5 mm
            ("diameter of its groove", 0.02, -BY_PINION / 2.0),
            *((what, by, -APART) for what, by, _ in AXES),
        ],
    ),
}
"""NaN where `test_machine.py` finds it another way."""


@pytest.fixture(scope="module")
def chains(best_dimensions: Dimensions) -> dict[str, Chain]:
    return {one.name: one for one in (*machine_chains(best_dimensions, "m"), *length_chains(best_dimensions, "m"))}


def test_every_chain_is_written_down(chains: dict[str, Chain]) -> None:
    assert chains.keys() == CHAINS.keys()


@pytest.mark.parametrize("name", CHAINS)
def test_a_chain_by_hand(chains: dict[str, Chain], name: str) -> None:
    nominal, high, lines = CHAINS[name]
    chain = chains[name]
    if not isnan(nominal):
        assert (chain.nominal, chain.high) == pytest.approx((nominal, high), abs=1e-9)
    assert [link.what for link in chain.links] == [what for what, *_ in lines]
    ends = [by if isinstance(by, tuple) else (-by, by) for _, by, _ in lines]
    assert [(link.lower_mm, link.upper_mm) for link in chain.links] == [pytest.approx(pair, abs=1e-12) for pair in ends]
    shares = [share for *_, share in lines]
    near = 1e-6 if name == "carriage's travel" else 1e-12  # the chain's are differences
    known = [link.share if isnan(share) else share for link, share in zip(chain.links, shares, strict=True)]
    assert [link.share for link in chain.links] == [pytest.approx(share, rel=near) for share in known]
    shares = known
    added = [(share * low, share * up) for (low, up), share in zip(ends, shares, strict=True)]
    worst = chain.nominal + sum(map(min, added)), chain.nominal + sum(map(max, added))
    assert chain.worst == pytest.approx(worst, abs=1e-5)
    wide = sqrt(sum(((up - low) / 2.0) ** 2 for low, up in added))
    middle = (worst[0] + worst[1]) / 2.0
    assert chain.rss == pytest.approx((middle - wide, middle + wide), abs=1e-5)


def test_the_largest_deviation_is_that_of_the_base_radius(
    best_dimensions: Dimensions, chains: dict[str, Chain]
) -> None:
    assert deviation_mm(chains["upper arm"]) == pytest.approx(
        PLACE + 0.012 + sum(by for _, by, _ in BALL if isinstance(by, float))
    )
    assert deviation_mm(chains["shoulder along its axis"]) == pytest.approx(
        0.012 * 91.0 / 15.2 + 2 * PLACE + DOWEL + 0.01 + 2 * 0.02 + 0.12
    )
    by_turn = 2 * PLACE * (sqrt(1.0 + LEVER**2) + LEVER - 1.0)
    assert largest_deviation_mm(best_dimensions, "m") == pytest.approx(3 * PLACE + 2 * DOWEL + SEAT + SHAFT + by_turn)
