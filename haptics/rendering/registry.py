"""All force laws by number, and their compiled dispatch; a new law is one line in `LAWS`.

What follows from that list: the width of a table's rows, the compiled force and energy of a row, the same in C, and the
columns that the C header and its guide name. Importing this module loads numba.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any

from numba import njit

from haptics.rendering.law import FIRST, KIND, Law, columns
from haptics.rendering.laws import constant_force, home, operating_resistance, spring, virtual_wall

LAWS: dict[int, Law] = {
    1: operating_resistance.LAW,
    2: spring.LAW,
    3: constant_force.LAW,
    4: home.LAW,
    5: virtual_wall.LAW,
}
"""Kind, as tables in files and in C have it and never to be given again -> law."""
COLUMNS = FIRST + max(sum(p.width for p in law.parameters.parameters().values()) for law in LAWS.values())
"""Doubles in a row of a table."""


def layout(law: Law) -> list[tuple[str, int, int, str]]:
    """Name, first column, number of columns and unit of each parameter of a law."""
    named = zip(law.parameters.parameters().items(), columns(law.parameters), strict=True)
    return [(name, first, parameter.width, parameter.unit) for (name, parameter), first in named]


@njit(cache=True, error_model="numpy")
def _no_force(laws, i, px, py, pz, vx, vy, vz):  # noqa: ARG001
    """Force of a row of unknown kind."""
    return 0.0, 0.0, 0.0


@njit(cache=True, error_model="numpy")
def _no_energy(laws, i, px, py, pz):  # noqa: ARG001
    """Energy of a row of unknown kind."""
    return 0.0


def _force_of(kind: int, force: Any, of_others: Any) -> Any:
    @njit(error_model="numpy")
    def force_of(laws, i, px, py, pz, vx, vy, vz):
        """Force of row i if it is of one kind, else of the others."""
        if laws[i, KIND] == kind:
            return force(laws, i, px, py, pz, vx, vy, vz)
        return of_others(laws, i, px, py, pz, vx, vy, vz)

    return force_of


def _energy_of(kind: int, energy: Any, of_others: Any) -> Any:
    @njit(error_model="numpy")
    def energy_of(laws, i, px, py, pz):
        """Energy of row i if it is of one kind, else of the others."""
        if laws[i, KIND] == kind:
            return energy(laws, i, px, py, pz)
        return of_others(laws, i, px, py, pz)

    return energy_of


def _dispatch(one: Callable[..., Any], form: str, nothing: Any) -> Any:
    """One compiled function that takes a row of any kind: a chain of comparisons, which the compiler makes flat."""
    last_first = reversed(LAWS.items())
    return reduce(lambda others, law: one(law[0], getattr(law[1], form), others), last_first, nothing)


force_of = _dispatch(_force_of, "force", _no_force)
energy_of = _dispatch(_energy_of, "energy", _no_energy)
