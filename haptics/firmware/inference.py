"""Types of a function's variables, as the compiler infers them, without compiling it."""

from __future__ import annotations

import io
import tokenize
from collections.abc import Callable
from functools import cache
from typing import Any

from numba.core import registry, types
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags
from numba.core.compiler_machinery import PassManager
from numba.core.typed_passes import NopythonTypeInference

from haptics.firmware.layout import is_record, is_row, is_scalar, is_table
from haptics.firmware.memories import Layout
from haptics.firmware.precision import INTEGER, REAL

REASON = "exact: "  # Begins the comment of a line that holds two real numbers to be equal


class _TypesOnly(CompilerBase):
    """The compiler's pipeline up to the types; code generation, which takes seconds, is left out."""

    def define_pipelines(self) -> list[PassManager]:
        manager = PassManager("types")
        manager.passes.extend(DefaultPassBuilder.define_untyped_pipeline(self.state).passes)
        manager.add_pass(NopythonTypeInference, "types")
        manager.finalize()
        return [manager]


@cache
def inferred(function: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[dict[str, Any], Any]:
    """Infers the types of a function's variables and of what it returns.

    Args:
        function: The Python function beneath a compiled one.
        arguments: Types of its arguments, the compiler's.

    Returns:
        Variable of the intermediate form -> type, and the type that is returned.

    Raises:
        numba.core.errors.TypingError: The compiler cannot type the function.
    """
    target: Any = registry.cpu_target
    target.target_context.refresh()
    flags: Any = Flags()
    flags.nrt, flags.error_model = True, "numpy"
    pipeline = _TypesOnly(target.typing_context, target.target_context, None, arguments, None, flags, {})
    pipeline.state.cr = ()  # the pipeline asks for a result, which code generation would have left
    pipeline.compile_extra(function)
    return pipeline.state.typemap, pipeline.state.return_type


def of_kind(kind: Any, real: Any) -> Any:
    """A type whose real number, or those of a tuple, are of a kind; arrays and records stay."""
    if isinstance(kind, types.Float):
        return real
    if isinstance(kind, types.BaseTuple) and not is_record(kind):
        return types.Tuple([of_kind(part, real) for part in kind])  # pyright: ignore
    return kind


def variables(typemap: dict[str, Any]) -> dict[str, Any]:
    """Name of each local variable -> its type; a double where one of its versions is."""
    result: dict[str, Any] = {}
    for name, kind in typemap.items():
        variable = name.split(".")[0]
        if variable.startswith("$") or variable in ("arg", "_"):
            continue
        own = plain(kind)
        if not (is_scalar(own) or is_row(own) or is_table(own) or is_record(own)):
            continue
        if variable not in result or isinstance(own, types.Float):
            result[variable] = own
    return result


def plain(kind: Any) -> Any:
    """A type as the compiler infers with: doubles, and without its knowledge of constants and alignment."""
    if isinstance(kind, Layout):
        return types.Array(REAL, 1, "C")
    if isinstance(kind, types.Float):
        return REAL
    if isinstance(kind, types.Boolean | types.BooleanLiteral):
        return types.boolean
    if isinstance(kind, types.Integer | types.IntegerLiteral):
        return INTEGER
    if isinstance(kind, types.Array):
        return types.Array(kind.dtype, kind.ndim, "C")
    return kind


def reasons(source: str) -> dict[int, str]:
    """Line of a source -> why two real numbers may be held to be equal there, by the comment at its end."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    comments = {t.start[0]: t.string.lstrip("# ") for t in tokens if t.type == tokenize.COMMENT}
    return {line: text.removeprefix(REASON) for line, text in comments.items() if text.startswith(REASON)}
