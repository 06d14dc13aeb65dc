"""Versions of packages: which of those installed differ from the ones that the tests ran with."""

from __future__ import annotations

import os
import sys

TESTED = {
    "cadquery": "2.8.0",
    "dask": "2026.8.0",
    "distributed": "2026.8.0",
    "ezdxf": "1.4.5",
    "fonttools": "4.68.0",
    "jinja2": "3.1.6",
    "lxml": "6.1.3",
    "matplotlib": "3.11.2",
    "msgspec": "0.22.0",
    "networkx": "3.6.1",
    "numba": "0.68.1",
    "numpy": "2.4.6",
    "pyarrow": "26.0.1",
    "pydantic": "2.14.3",
    "pymoo": "0.6.2",
    "python-fcl": "0.7.0.11",
    "rich": "14.3.4",
    "scipy": "1.17.1",
    "shtab": "1.13.0",
    "threadpoolctl": "3.8.0",
    "trimesh": "5.2.0",
    "viser": "1.1.1",
    "websockets": "16.1.1",
}
"""Package -> version; scripts/pins.py writes them from constraints.txt."""
_SAME = 2  # leading numbers of a version that must be equal


def series(version: str) -> tuple[str, ...]:
    """Takes the leading numbers of a version: releases that share them differ by corrections only."""
    return tuple(version.split(".")[:_SAME])


def installed() -> dict[str, str]:
    """Reads name -> version off the metadata folders on Python's path, whose names are standardised; in 1 ms."""
    found: dict[str, str] = {}
    for place in sys.path:
        try:
            names = os.listdir(place or ".")
        except OSError:  # a path may be a zip file, or nothing
            continue
        for name in names:
            if name.endswith(".dist-info"):
                package, _, version = name.removesuffix(".dist-info").partition("-")
                found.setdefault(package.lower().replace("_", "-").replace(".", "-"), version)
    return found


def difference() -> str:
    """States in one line which installed packages are of another series than the tested ones; "" for none."""
    here = installed()
    other = [
        f"{name} {here[name]} (tested: {version})"
        for name, version in TESTED.items()
        if name in here and series(here[name]) != series(version)
    ]
    return f"note: not the tested versions: {', '.join(other)}; make install installs the tested ones" if other else ""
