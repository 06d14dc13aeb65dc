"""Content fingerprint of a STEP file: equal exactly when the files say the same, however they number it.

A STEP file lists entities `#12=NAME(...)` that refer to each other by number. Numbers, the order of the lines, the
order inside sets and the counters of assembly occurrences differ from run to run; the content does not. So each
entity is hashed with every reference replaced by the hash of what it names (a Merkle graph), and the sorted multiset
of all hashes is hashed. The header (file name, time, system) is left out.

Cycles do not occur in a well-made file but are handled: entities on or above a cycle are hashed again and again until
that tells no more of them apart, which is all that a colour refinement can.
"""

from __future__ import annotations

import hashlib
import re
from collections import defaultdict
from pathlib import Path

TOKEN = re.compile(rb"'(?:[^']|'')*'|#\d+|[^'#]+|#")
WORD = re.compile(rb"'(?:[^']|'')*'|/\*.*?\*/|;|[^';/]+|/", re.DOTALL)
# Entities whose list of references is a SET in the EXPRESS schema, so that its order means nothing.
SET_TYPES = frozenset(
    {
        b"ADVANCED_BREP_SHAPE_REPRESENTATION",
        b"CLOSED_SHELL",
        b"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION",
        b"OPEN_SHELL",
        b"PRODUCT_RELATED_PRODUCT_CATEGORY",
        b"REPRESENTATION",
        b"SHAPE_REPRESENTATION",
    }
)
# Its first attribute is a counter of the writing process, not content; its second is the occurrence's name.
COUNTED_TYPE = b"NEXT_ASSEMBLY_USAGE_OCCURRENCE"
COUNTER = re.compile(rb"^'[^']*'")
SIZE = 20


class FingerprintError(ValueError):
    """The file is not a STEP file, or refers to an entity that it does not hold."""


def step_fingerprint(path: Path) -> str:
    """Computes the fingerprint of a STEP file, 64 hexadecimal digits.

    Raises:
        FingerprintError: No DATA section, or a reference to a missing entity.
    """
    return content_fingerprint(path.read_bytes())


def content_fingerprint(data: bytes) -> str:
    """Computes the fingerprint of the bytes of a STEP file, see `step_fingerprint`."""
    entities = _entities(data)
    hashes = _hashes(entities)
    return hashlib.sha256(b"".join(sorted(hashes.values()))).hexdigest()


class _Entity:
    """Text pieces between references, the references, and whether the references form a set."""

    __slots__ = ("content", "references", "unordered")

    def __init__(self, body: bytes) -> None:
        name, _, rest = body.partition(b"(")
        name = name.strip()
        if name == COUNTED_TYPE:
            rest = COUNTER.sub(b"''", rest.strip(), count=1)
        content: list[bytes] = [name, b"("]
        references: list[int] = []
        for token in TOKEN.findall(rest):
            if token[:1] == b"#" and len(token) > 1:
                references.append(int(token[1:]))
                content.append(b"#")
            elif token[:1] == b"'":
                content.append(token)
            else:
                content.append(b"".join(token.split()))
        self.content = b"".join(content)
        self.references = tuple(references)
        self.unordered = name in SET_TYPES

    def digest(self, colours: list[bytes]) -> bytes:
        """Hash of the text with the references' colours in their places."""
        if self.unordered:
            colours = sorted(colours)
        return hashlib.blake2b(self.content + b"\0" + b"".join(colours), digest_size=SIZE).digest()


def _entities(data: bytes) -> dict[int, _Entity]:
    """Number -> entity of the DATA section."""
    entities: dict[int, _Entity] = {}
    inside = False
    statement: list[bytes] = []
    for word in WORD.findall(data):
        if word == b";":
            text = b"".join(statement).strip()
            statement = []
            if text == b"ENDSEC":
                inside = False
            elif inside:
                number, _, body = text.partition(b"=")
                entities[int(number.strip()[1:])] = _Entity(body.strip())
            elif text.startswith(b"DATA"):
                inside = True
        elif not word.startswith(b"/*"):
            statement.append(word)
    if not entities:
        raise FingerprintError("no DATA section with entities: not a STEP file")
    for number, entity in entities.items():
        for reference in entity.references:
            if reference not in entities:
                raise FingerprintError(f"entity #{number} refers to #{reference}, which the file does not hold")
    return entities


def _hashes(entities: dict[int, _Entity]) -> dict[int, bytes]:
    """Hash of every entity, referenced ones first; what is on or above a cycle is refined together at the end."""
    users: dict[int, list[int]] = defaultdict(list)
    missing = {number: len(entity.references) for number, entity in entities.items()}
    for number, entity in entities.items():
        for reference in entity.references:
            users[reference].append(number)
    hashes: dict[int, bytes] = {}
    ready = [number for number, count in missing.items() if count == 0]
    while ready:
        number = ready.pop()
        hashes[number] = entities[number].digest([hashes[r] for r in entities[number].references])
        for user in users[number]:
            missing[user] -= 1
            if missing[user] == 0:
                ready.append(user)
    rest = entities.keys() - hashes.keys()
    colours, kinds = dict.fromkeys(rest, b"\0" * SIZE), 0
    while len(set(colours.values())) > kinds:
        kinds, known = len(set(colours.values())), hashes | colours
        colours = {n: entities[n].digest([known[r] for r in entities[n].references]) for n in rest}
    return hashes | colours
