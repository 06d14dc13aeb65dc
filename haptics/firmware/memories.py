"""The memories of supervisor and start-up as C structs: a member for each place of their layout, with its comment.

Python keeps each memory as one array of floats; the module that lays it out is read here: names, offsets and the
comment at the end of each line. In C a member is of the kind that its values need, so that a debugger shows them.
"""

from __future__ import annotations

import ast
import inspect
import io
import tokenize
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numba.core import types

from haptics.control.startup import record
from haptics.control.supervisor import memory
from haptics.firmware.precision import INTEGER, REAL, Precision

FLAG = types.int32
RESERVED = {"double", "long", "int", "row", "table", "part", "fill", "short", "float", "register", "signed", "default"}
# Places whose values are whole: states, codes and flags; bits and counts, which need more than 32 binary digits.
WHOLE = {
    **dict.fromkeys(("STATE", "REQUEST", "STARTED", "CHECKED", "KNOWN", "PLACED", "STILL", "SHORT", "PACED"), FLAG),
    **dict.fromkeys(("STEP", "CODE", "JOINT", "BEGUN", "TESTED"), FLAG),
    **dict.fromkeys(("LATCHED", "PRESENT", "SIGNALS", "TICKS", "REPEATS", "ALL_REPEAT", "MISSED"), INTEGER),
}
# Places that stay double in single precision: the clock, and sums over a long time; `precision` says why.
EXACT = {"NOW", "HEARD", "TANK", "GIVEN", "WINDING", "HOUSING"}


class Member(NamedTuple):
    """A place of a memory.

    Attributes:
        name: Of the constant that is its offset.
        first: Offset in Python's array.
        width: Number of values.
        about: Comment of its line: unit and meaning.
    """

    name: str
    first: int
    width: int
    about: str

    @property
    def c_name(self) -> str:
        """Name of the member in C."""
        name = self.name.lower()
        return f"{name}_" if name in RESERVED else name

    def kind(self, precision: Precision) -> Any:
        """Kind of its values in C."""
        if self.name in EXACT:
            return REAL
        return WHOLE.get(self.name, precision.real)


class Layout(NamedTuple):
    """A memory.

    Attributes:
        module: The module that lays it out.
        struct: Name of its struct in C.
        members: Constant's name -> its place, by rising offset.
    """

    module: ModuleType
    struct: str
    members: dict[str, Member]

    def __hash__(self) -> int:
        return hash(self.struct)

    @property
    def pointer(self) -> str:
        """C type of an argument."""
        return f"{self.struct} *"

    def definition(self, precision: Precision) -> str:
        """The struct, a member a line, with what Python's layout says of it."""
        lines = []
        for one in self.members.values():
            size = f"[{one.width}]" if one.width > 1 else ""
            lines.append(f"    {_c_type(one.kind(precision))} {one.c_name}{size}; /* {one.about} */")
        return "typedef struct {\n" + "\n".join(lines) + f"\n}} {self.struct};"

    def dtype(self, precision: Precision) -> np.dtype:
        """The struct as numpy reads it, in the layout of a C compiler for this machine or a Cortex-M."""
        kinds = {FLAG: "i4", INTEGER: "i8", REAL: "f8"}
        parts = [
            (one.c_name, kinds.get(one.kind(precision), "f4"), *([one.width] if one.width > 1 else []))
            for one in self.members.values()
        ]
        return np.dtype(parts, align=True)

    def initialiser(self, values: np.ndarray, literal: Any, precision: Precision) -> str:
        """What is not zero of a memory, as C initialises it."""
        lines = []
        for one in self.members.values():
            part = values[one.first : one.first + one.width]
            if not np.any(part):
                continue
            kind = one.kind(precision)
            texts = [str(int(v)) if one.name in WHOLE else literal(float(v), kind) for v in part]
            text = ", ".join(texts)
            lines.append(f".{one.c_name} = {{ {text} }}" if one.width > 1 else f".{one.c_name} = {text}")
        return "{ " + ", ".join(lines) + " }"


def _c_type(kind: Any) -> str:
    return {FLAG: "int", INTEGER: "long long", REAL: "double"}.get(kind, "delta_real")


def layout(module: Any, struct: str) -> Layout:
    """Reads a layout: `NAME = offset  # comment`, one a line, up to `MEMORY`, the number of all places.

    Raises:
        ValueError: A place has no comment, or the offsets do not rise.
    """
    source = inspect.getsource(module)
    comments = {
        token.start[0]: token.string.lstrip("# ")
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
    }
    found: list[tuple[str, int, str]] = []
    for node in ast.parse(source).body:
        if not (isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)):
            continue
        name, value = node.targets[0].id, node.value
        if isinstance(value, ast.Constant) and type(value.value) is int:
            found.append((name, value.value, comments.get(node.lineno, "")))
        if name == "MEMORY":
            break
    ends = [first for _, first, _ in found[1:]]
    members = {
        name: Member(name, first, end - first, about)
        for (name, first, about), end in zip(found[:-1], ends, strict=True)
    }
    for one in members.values():
        if one.width < 1 or not one.about:
            raise ValueError(f"{module.__name__}.{one.name}: offsets must rise, and each line needs a comment")
    return Layout(module, struct, members)


SUPERVISOR = layout(memory, "delta_supervisor")
START = layout(record, "delta_startup_state")
# Record and field that hold a memory -> its layout.
LAID = {
    ("Memory", "supervisor"): SUPERVISOR,
    ("StartMemory", "supervisor"): SUPERVISOR,
    ("StartMemory", "start"): START,
}
