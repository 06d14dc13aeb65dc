"""C types of compiled functions: scalars, rows and tables of doubles, records, and returned tuples."""

from __future__ import annotations

import re

from numba.core import types

from haptics.firmware.memories import FLAG, LAID, Layout
from haptics.firmware.precision import SINGLE, Precision

WIDE = "_wide"  # Ending of a record's field that is kept as a double beside the single one

# Minimum and maximum take the first where the second is not a number, as Python's do.
_EXTREMES = """\
static inline {type} min2{end}({type} a, {type} b) {{ return b < a ? b : a; }}
static inline {type} max2{end}({type} a, {type} b) {{ return b > a ? b : a; }}
static inline int equal{end}({type} a, {type} b) {{ return a <= b && a >= b; }} /* each call says why */
"""
# One instruction each where the core has it; a freestanding compiler would call the library for the same values.
_BUILTIN = """\
#ifdef __GNUC__
#define DELTA_BUILTIN(name) __builtin_##name
#else
#define DELTA_BUILTIN(name) name
#endif
"""
_PRELUDE = """\
typedef struct {{ delta_real *at; long long n; }} row;
typedef struct {{ delta_real *at; long long rows, columns, stride; }} table;

{extremes}\
static inline long long imin2(long long a, long long b) {{ return b < a ? b : a; }}
static inline long long imax2(long long a, long long b) {{ return b > a ? b : a; }}
static inline row row_of(table t, long long i) {{ row r = {{ t.at + i * t.stride, t.columns }}; return r; }}
static inline row part(row r, long long a, long long b) {{ row p = {{ r.at + a, b - a }}; return p; }}
static inline table table_part(table t, long long a, long long b, long long c, long long d)
{{
    table p = {{ t.at + a * t.stride + c, b - a, d - c, t.stride }};
    return p;
}}
static inline void fill(row r, delta_real value) {{ for (long long k = 0; k < r.n; k++) r.at[k] = value; }}
"""


def prelude(precision: Precision, code: str) -> str:
    """What a translation begins with: arrays, minimum and maximum, in a precision; only the functions that it calls."""
    double = _EXTREMES.format(type="double", end="")
    single = _EXTREMES.format(type="float", end="f") if precision.single else ""
    parts = re.split(r"^(?=static )", _PRELUDE.format(extremes=double + single), flags=re.M)
    named = ((part, re.match(r"static inline .*?(\w+)\(", part)) for part in parts)
    used = [name + end for name in ("fabs", "floor", "sqrt") for end in ("", "f") if f"delta_{name}{end}(" in code]
    builtins = "".join(f"#define delta_{name}(x) DELTA_BUILTIN({name})(x)\n" for name in used)
    return (
        (_BUILTIN if used else "")
        + builtins
        + "".join(part for part, name in named if name is None or f"{name[1]}(" in code)
    )


class LayoutError(TypeError):
    """A type that has no counterpart in C here."""


def is_scalar(kind: types.Type) -> bool:
    """Whether a type is a number; literal integers count as such."""
    return isinstance(kind, types.Float | types.Integer | types.Boolean)


def is_row(kind: types.Type) -> bool:
    """Whether a type is a one-dimensional array."""
    return isinstance(kind, types.Array) and kind.ndim == 1


def is_table(kind: types.Type) -> bool:
    """Whether a type is a two-dimensional array."""
    return isinstance(kind, types.Array) and kind.ndim == 2


def is_record(kind: types.Type) -> bool:
    """Whether a type is a NamedTuple."""
    return isinstance(kind, types.BaseNamedTuple)


def record_name(kind: types.Type) -> str:
    """Name of a record's struct: that of the NamedTuple."""
    return kind.instance_class.__name__  # pyright: ignore[reportAttributeAccessIssue]


def members(kind: types.Type) -> list[tuple[str, types.Type]]:
    """Fields of a record with their types."""
    return list(zip(kind.fields, kind.types, strict=True))  # pyright: ignore[reportAttributeAccessIssue]


def c_type(kind: types.Type) -> str:
    """C type of a value or an argument.

    Args:
        kind: The compiler's type.

    Returns:
        C text; records as pointers to constants, arrays by value (they hold a pointer).

    Raises:
        LayoutError: There is none.
    """
    if isinstance(kind, Layout):
        return kind.pointer
    if isinstance(kind, types.Boolean) or kind == FLAG:
        return "int"
    if isinstance(kind, types.Float):
        return "float" if kind == SINGLE else "double"
    if isinstance(kind, types.Integer):
        return "long long"
    if is_row(kind):
        return "row"
    if is_table(kind):
        return "table"
    if is_record(kind):
        return f"const {record_name(kind)} *"
    if isinstance(kind, types.NoneType):
        return "void"
    if isinstance(kind, types.BaseTuple):
        return tuple_name(kind)
    raise LayoutError(f"no C type for {kind}")


def letter(kind: types.Type) -> str:
    """What C puts behind the names of functions of singles."""
    return "f" if kind == SINGLE else ""


def tuple_name(kind: types.Type) -> str:
    """Name of the struct that a returned tuple becomes."""
    letters = "".join(letter(part) or "d" if isinstance(part, types.Float) else "l" for part in kind)  # pyright: ignore
    return f"tuple_{letters}"


def struct(kind: types.Type, precision: Precision) -> str:
    """Definition of the struct of a record or a tuple; in mixed precision a record has its numbers in both kinds."""
    if is_record(kind):
        lines = []
        for name, part in members(kind):
            laid = LAID.get((record_name(kind), name))
            if laid:
                lines.append(f"    {laid.pointer}{name};")
                continue
            real = isinstance(part, types.Float)
            text = record_name(part) if is_record(part) else c_type(precision.real if real else part)
            lines.append(f"    {text} {name};")
            if real and precision.single:
                lines.append(f"    double {name}{WIDE};")
        return "typedef struct {\n" + "\n".join(lines) + f"\n}} {record_name(kind)};\n"
    parts = "".join(f" {c_type(part)} v{k};" for k, part in enumerate(kind))  # pyright: ignore
    return f"typedef struct {{{parts} }} {tuple_name(kind)};\n"
