"""A build as another command reads it: its files as long as they are those of its manifest and of a design."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from delta_cad.common.reading import ReadError, parse_json, read_bounded, read_json
from delta_cad.design import Design, design_hash

MODEL, PAGE = "assembly.glb", "report.html"
_LATEST = "shoulder_rad"  # of the mechanism, what was added to the page last
_PROGRAM = "delta-haptics"
_DATA = b'<script type="application/json" id="data">', b"</script>"  # of the page, as `page.html` writes it


class StaleBuildError(Exception):
    """Why the files of a folder are not those of a design as this version builds it."""


@dataclass(frozen=True)
class Build:
    """A folder and its manifest.

    Attributes:
        folder: The folder.
        input_sha256: Hash of the design.
        files: Name -> SHA-256, of the manifest.
    """

    folder: Path
    input_sha256: str
    files: Mapping[str, str]

    @classmethod
    def read(cls, folder: Path) -> Build:
        """Opens the build in a folder, of whatever design.

        Raises:
            StaleBuildError: There is none, or it is one of another version.
        """
        if not (folder / "manifest.json").is_file():
            raise StaleBuildError(f"no build in {folder}")
        try:
            manifest = read_json(folder / "manifest.json")
            own, version = str(manifest["input_sha256"]), manifest["versions"][_PROGRAM]
            files = {str(name): str(entry["sha256"]) for name, entry in manifest["files"].items()}
        except (ReadError, AttributeError, LookupError, TypeError):
            raise StaleBuildError(f"{folder}/manifest.json cannot be read") from None
        if version != (here := metadata.version(_PROGRAM)):
            raise StaleBuildError(f"{folder} is of version {version}, this is {here}")
        return cls(folder, own, files)

    @classmethod
    def of(cls, design: Design, folder: Path) -> Build:
        """Opens the build of a design in a folder; raises as `read`, and where it is one of another design."""
        found = cls.read(folder)
        if found.input_sha256 != design_hash(design):
            raise StaleBuildError(f"{folder} is of another design")
        return found

    def content(self, name: str) -> bytes:
        """Reads a file.

        Raises:
            StaleBuildError: The build has none of this name, or it was changed since.
        """
        if name not in self.files:
            raise StaleBuildError(f"{self.folder} was built without {name}")
        try:
            content = read_bounded(self.folder / name)
        except ReadError as error:
            raise StaleBuildError(f"{self.folder}/{error}") from None
        if hashlib.sha256(content).hexdigest() != self.files[name]:
            raise StaleBuildError(f"{self.folder}/{name} was changed after the build")
        return content

    def json(self, name: str) -> Any:
        """Reads a JSON file; raises as `content`."""
        return self._parsed(self.content(name), name)

    def scene(self) -> dict[str, Any]:
        """Reads from the page what `page.scene` wrote into it: what moves the model, and how; raises as `content`."""
        _, _, rest = self.content(PAGE).partition(_DATA[0])
        scene = self._parsed(rest.partition(_DATA[1])[0], PAGE)
        if not (isinstance(scene, dict) and _LATEST in scene.get("mechanism", {})):
            raise StaleBuildError(f"{self.folder}/{PAGE} is of an earlier version; build it again")
        return scene

    def _parsed(self, content: bytes, name: str) -> Any:
        try:
            return parse_json(content, name)
        except ReadError as error:
            raise StaleBuildError(f"{self.folder}/{error}") from None


def find_build(design: Design, folders: Iterable[Path]) -> tuple[Build | None, str]:
    """Finds the build of a design.

    Args:
        design: The design.
        folders: Where it may be, the most likely first.

    Returns:
        The build, and ""; None, and why the first of the folders has none.
    """
    reasons = []
    for folder in folders:
        try:
            return Build.of(design, folder), ""
        except StaleBuildError as error:
            reasons.append(str(error))
    return None, reasons[0]
