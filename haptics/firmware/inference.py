"""Types of a function's variables, as the compiler infers them, without compiling it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from numba.core import registry
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags
from numba.core.compiler_machinery import PassManager
from numba.core.typed_passes import NopythonTypeInference


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
