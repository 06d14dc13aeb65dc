"""Content fingerprint of a STEP file: equal exactly when the files say the same, however they number it.

A STEP file lists entities `#12=NAME(...)` that refer to each other by number. Numbers, the order of the lines, the
order inside sets and the counters of assembly occurrences differ from run to run; the content does not. So each
entity is hashed with every reference replaced by the hash of what it names (a Merkle graph), and the sorted multiset
of all hashes is hashed. The header (file name, time, system) is left out.

Cycles do not occur in a well-made file but are handled: inside a strongly connected component the hashes are
refined as many times as it has members, which separates all that a colour refinement can.
"""

from __future__ import annotations

import hashlib
import re
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
    """Fingerprint of a STEP file.

    Returns:
        64 hexadecimal digits.

    Raises:
        FingerprintError: No DATA section, or a reference to a missing entity.
    """
    return content_fingerprint(path.read_bytes())


def content_fingerprint(data: bytes) -> str:
    """Fingerprint of the bytes of a STEP file, see `step_fingerprint`."""
    entities = _entities(data)
    hashes = _hashes(entities)
    digest = hashlib.sha256()
    for value in sorted(hashes.values()):
        digest.update(value)
    return digest.hexdigest()


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
    """Hash of every entity, referenced ones first."""
    hashes: dict[int, bytes] = {}
    for component in _components(entities):
        members = set(component)
        first = entities[component[0]]
        if len(component) == 1 and component[0] not in first.references:
            hashes[component[0]] = first.digest([hashes[r] for r in first.references])
            continue
        colours = dict.fromkeys(component, b"\0" * SIZE)
        for _ in component:
            colours = {
                n: entities[n].digest([colours[r] if r in members else hashes[r] for r in entities[n].references])
                for n in component
            }
        hashes.update(colours)
    return hashes


def _components(entities: dict[int, _Entity]) -> list[list[int]]:
    """Strongly connected components, each after all that it refers to (Tarjan, without recursion)."""
    index: dict[int, int] = {}
    low: dict[int, int] = {}
    on_stack: set[int] = set()
    stack: list[int] = []
    components: list[list[int]] = []
    for root in entities:
        if root in index:
            continue
        index[root] = low[root] = len(index)
        stack.append(root)
        on_stack.add(root)
        work = [(root, iter(entities[root].references))]
        while work:
            node, references = work[-1]
            for reference in references:
                if reference not in index:
                    index[reference] = low[reference] = len(index)
                    stack.append(reference)
                    on_stack.add(reference)
                    work.append((reference, iter(entities[reference].references)))
                    break
                if reference in on_stack:
                    low[node] = min(low[node], index[reference])
            else:
                work.pop()
                if work:
                    parent = work[-1][0]
                    low[parent] = min(low[parent], low[node])
                if low[node] == index[node]:
                    component: list[int] = []
                    while True:
                        member = stack.pop()
                        on_stack.discard(member)
                        component.append(member)
                        if member == node:
                            break
                    components.append(component)
    return components
