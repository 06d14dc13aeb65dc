"""How the types of compiled functions look in C: scalars, rows and tables of doubles, records, and tuples returned."""

from __future__ import annotations

from numba.core import types

# Minimum and maximum take the first where the second is not a number, as Python's do.
PRELUDE = """\
typedef struct { double *at; long n; } row;
typedef struct { double *at; long rows, columns; } table;

static inline double min2(double a, double b) { return b < a ? b : a; }
static inline double max2(double a, double b) { return b > a ? b : a; }
static inline long long imin2(long long a, long long b) { return b < a ? b : a; }
static inline long long imax2(long long a, long long b) { return b > a ? b : a; }
static inline row row_of(table t, long i) { row r = { t.at + i * t.columns, t.columns }; return r; }
static inline row part(row r, long first, long end) { row p = { r.at + first, end - first }; return p; }
static inline void fill(row r, double value) { for (long k = 0; k < r.n; k++) r.at[k] = value; }
"""


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
    if isinstance(kind, types.Boolean):
        return "int"
    if isinstance(kind, types.Float):
        return "double"
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


def tuple_name(kind: types.Type) -> str:
    """Name of the struct that a returned tuple becomes."""
    letters = "".join("d" if isinstance(part, types.Float) else "l" for part in kind)  # pyright: ignore
    return f"tuple_{letters}"


def struct(kind: types.Type) -> str:
    """Definition of the struct of a record or a tuple."""
    if is_record(kind):
        lines = []
        for name, part in members(kind):
            text = record_name(part) if is_record(part) else c_type(part)
            lines.append(f"    {text} {name};")
        return "typedef struct {\n" + "\n".join(lines) + f"\n}} {record_name(kind)};\n"
    parts = "".join(f" {c_type(part)} v{k};" for k, part in enumerate(kind))  # pyright: ignore
    return f"typedef struct {{{parts} }} {tuple_name(kind)};\n"
