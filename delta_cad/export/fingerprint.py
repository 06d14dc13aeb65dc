"""Content fingerprint of a STEP file: equal exactly when the files say the same, however they number it.

A STEP file lists entities `#12=NAME(...)` that refer to each other by number. Numbers, the order of the lines, the
order inside sets and the counters of assembly occurrences differ from run to run; the content does not. So each
entity is hashed with every reference replaced by the hash of what it names (a Merkle graph), and the sorted multiset
of all hashes is hashed. The header (file name, time, system) is left out.

`canonical` goes the other way: it numbers and orders the entities by what they are and by what refers to them, so that
files that say the same are the same bytes.

Cycles do not occur in a well-made file but are handled: entities on or above a cycle are hashed again and again until
that tells no more of them apart, which is all that a colour refinement can.
"""

from __future__ import annotations

import hashlib
import re
from collections import defaultdict

_TOKEN = re.compile(rb"'(?:[^']|'')*'|#\d+|[^'#]+|#")
WORD = re.compile(rb"'(?:[^']|'')*'|/\*.*?\*/|;|[^';/]+|/", re.DOTALL)
# Entities whose list of references is a SET in the EXPRESS schema, so that its order means nothing.
_SET_TYPES = frozenset(
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
_COUNTED_TYPE = b"NEXT_ASSEMBLY_USAGE_OCCURRENCE"
_BETWEEN_RECORDS = re.compile(rb"\)(?=[A-Z])")  # of an entity of several types
_REFERENCES = re.compile(rb"\((#\d+(?:,#\d+)*)\)")
_COUNTER = re.compile(rb"^'[^']*'")
_SIZE = 20


class FingerprintError(ValueError):
    """The file is not a STEP file, or refers to an entity that it does not hold."""


def canonical(data: bytes) -> tuple[bytes, str]:
    """The bytes of a STEP file with its entities in an order, and under numbers, that follow from its content alone.

    Each entity gets the hash of what it refers to, then that of what refers to it and in which place, then once more
    that of what it refers to: two that are equal in all may be exchanged. From those that nothing refers to, least hash
    first, each is written after all that it refers to. Sets are put in the order of their new numbers, and occurrences
    are counted from 1.

    Returns:
        data: The file, header as it is, one entity a line.
        fingerprint: 64 hexadecimal digits, those of the file given and of the file written.

    Raises:
        FingerprintError: No DATA section, or a reference to a missing entity.
    """
    entities = _entities(data)
    hashes = _hashes(entities)
    fingerprint = hashlib.sha256(b"".join(sorted(hashes.values()))).hexdigest()
    above: dict[int, list[tuple[int, int]]] = {number: [] for number in entities}
    for number, entity in entities.items():
        for place, reference in enumerate(entity.references):
            above[reference].append((number, 0 if entity.unordered else place))
    known = dict(hashes)
    for number in reversed(hashes):  # what refers to an entity comes before it
        users = sorted(known[user] + b"%d" % place for user, place in above[number])
        known[number] = hashlib.blake2b(hashes[number] + b"".join(users), digest_size=_SIZE).digest()
    hashes = _hashes(entities, known)

    def parts(number: int) -> list[int]:
        references = list(entities[number].references)
        return sorted(references, key=hashes.__getitem__) if entities[number].unordered else references

    order: dict[int, int] = {}
    begun: set[int] = set()
    for root in sorted((n for n in entities if not above[n]), key=hashes.__getitem__) + sorted(entities):
        stack = [(root, iter(parts(root)))] if root not in begun else []
        begun.add(root)
        while stack:
            number, rest = stack[-1]
            following = next((r for r in rest if r not in begun), None)
            if following is None:
                order[number] = len(order) + 1
                stack.pop()
            else:
                begun.add(following)
                stack.append((following, iter(parts(following))))
    lines, count = [], 0
    for number in order:
        text = entities[number].text(order)
        if entities[number].unordered:
            text = _REFERENCES.sub(_ascending, text)
        if text.startswith(_COUNTED_TYPE):
            count += 1
            text = _counted(text, b"%d" % count)
        lines.append(b"#%d = %s;\n" % (order[number], text))
    head, _, rest = data.partition(b"DATA;")
    return head + b"DATA;\n" + b"".join(lines) + rest[rest.rindex(b"ENDSEC;") :], fingerprint


def _ascending(match: re.Match[bytes]) -> bytes:
    """A list of references by number."""
    numbers = sorted(int(word[1:]) for word in bytes(match[1]).split(b","))
    return b"(" + b",".join(b"#%d" % number for number in numbers) + b")"


class _Entity:
    """An entity's tokens, numbers those of what it refers to, and whether these form a set; blanks count in strings."""

    __slots__ = ("content", "references", "tokens", "unordered")

    def __init__(self, body: bytes) -> None:
        self.tokens = [
            int(t[1:]) if t[:1] == b"#" and len(t) > 1 else t if t[:1] == b"'" else b"".join(t.split())
            for t in _TOKEN.findall(body)
        ]
        self.references = tuple(token for token in self.tokens if isinstance(token, int))
        name = body.partition(b"(")[0].strip()
        self.unordered = name in _SET_TYPES
        self.content = b"".join(b"#" if isinstance(token, int) else token for token in self.tokens)
        if name == _COUNTED_TYPE:
            self.content = _counted(self.content, b"")

    def digest(self, colours: list[bytes], own: bytes = b"") -> bytes:
        """Hash of the text with the references' colours in their places, and of what else is known of the entity."""
        if self.unordered:
            colours = sorted(colours)
        return hashlib.blake2b(self.content + b"\0" + b"".join(colours) + own, digest_size=_SIZE).digest()

    def text(self, order: dict[int, int]) -> bytes:
        """The entity with what it refers to under other numbers."""
        return b"".join(
            b"#%d" % order[t] if isinstance(t, int) else t if t[:1] == b"'" else _BETWEEN_RECORDS.sub(b") ", t)
            for t in self.tokens
        )


def _counted(text: bytes, count: bytes) -> bytes:
    """An occurrence's text with another counter."""
    return _COUNTED_TYPE + b"(" + _COUNTER.sub(b"'" + count + b"'", text[len(_COUNTED_TYPE) + 1 :], count=1)


def _entities(data: bytes) -> dict[int, _Entity]:
    """Number -> entity of the DATA section, comments left out."""
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


def _hashes(entities: dict[int, _Entity], own: dict[int, bytes] | None = None) -> dict[int, bytes]:
    """Hash of every entity, after those that it refers to; what is on or above a cycle is refined at the end."""
    users: dict[int, list[int]] = defaultdict(list)
    missing = {number: len(entity.references) for number, entity in entities.items()}
    for number, entity in entities.items():
        for reference in entity.references:
            users[reference].append(number)
    hashes: dict[int, bytes] = {}
    ready = [number for number, count in missing.items() if count == 0]
    while ready:
        number = ready.pop()
        entity = entities[number]
        hashes[number] = entity.digest([hashes[r] for r in entity.references], own[number] if own else b"")
        for user in users[number]:
            missing[user] -= 1
            if missing[user] == 0:
                ready.append(user)
    rest = entities.keys() - hashes.keys()
    colours, kinds = {n: own[n] if own else b"\0" * _SIZE for n in rest}, 0
    while len(set(colours.values())) > kinds:
        kinds, known = len(set(colours.values())), hashes | colours
        colours = {n: entities[n].digest([known[r] for r in entities[n].references]) for n in rest}
    return hashes | colours
