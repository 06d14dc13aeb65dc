"""Manifest of a build: digest and size of each file, content fingerprint of the STEP, versions, input, status."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

_SCHEMA = "delta-manifest/1"
_FILE_NAME = "manifest.json"
PACKAGES = (
    "delta-haptics",
    "cadquery",
    "cadquery-ocp",
    "numpy",
    "scipy",
    "trimesh",
    "python-fcl",
    "vtk",
    "ezdxf",
    "fonttools",
)
_STATUSES = ("passed", "rejected")


class ManifestError(ValueError):
    """The status of a build is unknown."""


def write_manifest(
    folder: Path, *, input_hash: str, status: str, fingerprint: str, left_out: Sequence[str] = ()
) -> dict[str, Any]:
    """Writes `manifest.json` over all files that the folder holds.

    Args:
        folder: The finished folder; only the manifest itself is missing.
        input_hash: SHA-256 of the design that was built, hexadecimal.
        status: "passed" or "rejected".
        fingerprint: Content fingerprint of the assembly's STEP file.
        left_out: Names of what a build makes and this one was asked not to.

    Returns:
        What was written.

    Raises:
        ManifestError: The status is unknown.
    """
    if status not in _STATUSES:
        raise ManifestError(f"status {status!r} is not one of {', '.join(_STATUSES)}")
    manifest = {
        "schema": _SCHEMA,
        "status": status,
        "input_sha256": input_hash,
        "step_fingerprint": fingerprint,
        "left_out": list(left_out),
        "versions": versions(),
        "files": {name: _digest(folder / name) for name in _files(folder)},
    }
    (folder / _FILE_NAME).write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")
    return manifest


def versions() -> dict[str, str]:
    """Gives the versions of Python, the kernel and the packages that had a part in the result."""
    import OCP

    kernel = ".".join(OCP.__version__.split(".")[:3])  # the binding appends its own counter
    versions = {"python": platform.python_version(), "occt": kernel}
    for package in PACKAGES:
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            versions[package] = "not installed"
    return versions


def _files(folder: Path) -> list[str]:
    """Relative names of all files but the manifest, sorted."""
    names = (path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    return sorted(name for name in names if name != _FILE_NAME)


def _digest(path: Path) -> dict[str, Any]:
    data = path.read_bytes()
    return {"sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data)}
