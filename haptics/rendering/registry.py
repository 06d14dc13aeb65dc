"""All force laws by number, and their compiled dispatch; a new law is one line in `LAWS`.

What follows from that list: the width of a table's rows, the compiled force and energy of a row, the same in C, and the
columns that the C header and its guide name. Importing this module loads numba.
"""

from __future__ import annotations

from delta_cad.common.jit import unrolled_dispatch
from haptics.rendering.law import FIRST, KIND, Law, columns
from haptics.rendering.laws import constant_force, home, operating_resistance, spring, virtual_wall

# Kind, as tables in files and in C have it and never to be given again -> law.
LAWS: dict[int, Law] = {
    1: operating_resistance.LAW,
    2: spring.LAW,
    3: constant_force.LAW,
    4: home.LAW,
    5: virtual_wall.LAW,
}
# Doubles in a row of a table.
COLUMNS = FIRST + max(sum(p.width for p in law.parameters.parameters().values()) for law in LAWS.values())


def layout(law: Law) -> list[tuple[str, int, int, str]]:
    """Name, first column, number of columns and unit of each parameter of a law."""
    named = zip(law.parameters.parameters().items(), columns(law.parameters), strict=True)
    return [(name, first, parameter.width, parameter.unit) for (name, parameter), first in named]


_STATE = "laws, i, px, py, pz"
_OF_KIND = f"if laws[i, {KIND}] == {{1}}: return {{0}}(%s)  # exact: a kind is a whole number"
# Compiled: force of row i of a table at gain 1, N; none for a row of unknown kind.
force_of = unrolled_dispatch(
    f"{_STATE}, vx, vy, vz",
    [(law.force, kind) for kind, law in LAWS.items()],
    _OF_KIND % f"{_STATE}, vx, vy, vz",
    "return 0.0, 0.0, 0.0",
)
# Compiled: energy that row i of a table stores at gain 1, J.
energy_of = unrolled_dispatch(
    _STATE, [(law.energy, kind) for kind, law in LAWS.items()], _OF_KIND % _STATE, "return 0.0"
)
