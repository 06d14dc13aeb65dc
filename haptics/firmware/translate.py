"""Compiled Python functions to C99: the part of the language that a tick uses.

The functions are read as syntax trees; types come from numba's own inference, so that what is an integer there is one
here. Understood are arithmetic on doubles and integers, comparisons, conditions, `for ... in range`, `while`, tuples
that are taken apart at once, rows and tables of doubles, fields of NamedTuples, and calls of other compiled functions,
which are translated too. Constants of modules are written out. Anything else is refused, with function and line.

Floating point is kept as it is: same order of operations, no contraction (compile with `-ffp-contract=off`), squares
and cubes as the products that numba makes of them.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from numba.core import types

from haptics.firmware.expressions import Expressions
from haptics.firmware.layout import c_type, is_record, is_row, is_scalar, record_name, struct, tuple_name
from haptics.firmware.literals import Value, as_whole, cast
from haptics.firmware.memories import Layout
from haptics.firmware.precision import DOUBLE, INTEGER, REAL, Precision


class Translation:
    """C text of functions and of all that they need, in the order in which C wants it.

    Args:
        precision: Of its real numbers.

    Attributes:
        precision: Likewise.
        functions: C name -> definition.
        structs: C name -> definition.
    """

    def __init__(self, precision: Precision = DOUBLE) -> None:
        self.precision = precision
        self.functions: dict[str, str] = {}
        self.structs: dict[str, str] = {}
        self._returns: dict[str, Any] = {}
        self._names: dict[Any, str] = {}

    def add(self, function: Any, arguments: tuple[Any, ...]) -> tuple[str, Any]:
        """Translates a function with everything that it calls.

        Args:
            function: A compiled one.
            arguments: Types of its arguments, the compiler's.

        Returns:
            Its name in C and its return type.

        Raises:
            TranslationError: Something in it, or in a function that it calls, has no translation.
        """
        name = self._name(function)
        if name not in self.functions:
            written = _Function(self, function, arguments)
            text = written.text(name)
            self.functions[name] = text
            self._returns[name] = written.returns
        return name, self._returns[name]

    def _name(self, function: Any) -> str:
        """Last part of the module's name and the function's own, numbered where two are the same."""
        if function not in self._names:
            plain = f"{function.py_func.__module__.rsplit('.', 1)[-1]}_{function.py_func.__name__.strip('_')}"
            same = sum(name.rpartition("__")[0] == plain or name == plain for name in self._names.values())
            self._names[function] = f"{plain}__{same + 1}" if same else plain
        return self._names[function]

    def record(self, kind: Any) -> None:
        """Defines the struct of a record or tuple, those inside it first."""
        name = record_name(kind) if is_record(kind) else tuple_name(kind)
        if name in self.structs:
            return
        for part in kind:
            if is_record(part):
                self.record(part)
        self.structs[name] = struct(kind, self.precision)


class _Function(Expressions):
    """One function on its way to C, statement by statement."""

    def text(self, name: str) -> str:
        """Writes the definition of the function in C: its head, its variables, its statements.

        Args:
            name: What it is called in C.
        """
        for statement in self.tree.body:
            self.statement(statement)
        parts = [f"{c_type(self.types[a])} {self.local(a)}".replace("* ", "*") for a in self.arguments]
        head = f"{c_type(self.returns)} {name}({', '.join(parts)})"
        declared = [
            f"    {c_type(kind)} {self.local(variable)};".replace("* ", "*")
            for variable, kind in sorted(self.types.items())
            if variable not in self.arguments
        ]
        used = {node.id for node in ast.walk(self.tree) if isinstance(node, ast.Name)}
        unused = [f"    (void){self.local(argument)};" for argument in self.arguments if argument not in used]
        about = (self.python.__doc__ or "").strip().split("\n")[0]
        return "\n".join([f"/* {about} */", f"static {head}", "{", *declared, *unused, *self.lines, "}"]) + "\n"

    def statement(self, node: ast.stmt) -> None:
        handler: Callable[[Any], None] | None = getattr(self, f"do_{type(node).__name__.lower()}", None)
        if handler is None:
            raise self.refuse(node, f"{type(node).__name__} has no translation")
        handler(node)

    def do_expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Constant):  # a docstring
            return
        text, _ = self.value(node.value)
        self.emit(f"(void){text};")

    def do_pass(self, _node: ast.Pass) -> None:
        self.emit(";")

    def do_break(self, _node: ast.Break) -> None:
        self.emit("break;")

    def do_continue(self, _node: ast.Continue) -> None:
        self.emit("continue;")

    def do_return(self, node: ast.Return) -> None:
        if node.value is None:
            self.emit("return;")
            return
        if isinstance(self.returns, types.BaseTuple):
            parts = self.several(node.value, len(self.returns))
            texts = [cast(part, kind) for part, kind in zip(parts, tuple(self.returns), strict=True)]  # pyright: ignore
            self.emit(f"return ({tuple_name(self.returns)}){{ {', '.join(texts)} }};")
            return
        self.emit(f"return {cast(self.value(node.value), self.returns)};")

    def do_assign(self, node: ast.Assign) -> None:
        first = node.targets[0]
        before, self.exact = self.exact, self.exact or any(map(self.kept_exact, node.targets))
        try:
            self.assign(node, first)
        finally:
            self.exact = before

    def kept_exact(self, target: ast.expr) -> bool:
        """Whether a place, or one of a tuple's, keeps a double."""
        if isinstance(target, ast.Tuple):
            return any(map(self.kept_exact, target.elts))
        if isinstance(target, ast.Subscript) and not (
            isinstance(target.slice, ast.Constant) and target.slice.value is ...
        ):
            return self.place_kind(target) == REAL
        return isinstance(target, ast.Name) and self.types.get(target.id) == REAL

    def place_kind(self, target: ast.expr) -> Any:
        """Kind of what a place of an array holds."""
        mark, count = len(self.lines), self.temporaries
        kind = self.value(target)[1]
        del self.lines[mark:]
        self.temporaries = count
        return kind

    def is_whole(self, target: ast.expr) -> bool:
        """Whether a place of a memory holds a whole number, where Python has a float."""
        filled = isinstance(target, ast.Subscript) and not isinstance(target.slice, ast.Constant)
        return filled and isinstance(self.place_kind(target), types.Integer)

    def assign(self, node: ast.Assign, first: ast.expr) -> None:
        if isinstance(first, ast.Tuple):
            if len(node.targets) > 1:
                raise self.refuse(node, "a chain of tuples has no translation")
            parts = [
                (self.whole(given), INTEGER) if given and self.is_whole(place) else part
                for place, part, given in zip(
                    first.elts,
                    self.several(node.value, len(first.elts)),
                    node.value.elts if isinstance(node.value, ast.Tuple) else [None] * len(first.elts),
                    strict=True,
                )
            ]
            if len(parts) > 1:  # all are taken before any is changed
                parts = [
                    (text, kind)
                    if as_whole(text) or (isinstance(one, ast.Name) and one.id == "_")
                    else (self.temporary(kind, text), kind)
                    for one, (text, kind) in zip(first.elts, parts, strict=True)
                ]
            for target, part in zip(first.elts, parts, strict=True):
                self.store(target, part)
            return
        if isinstance(first, ast.Subscript) and isinstance(first.slice, ast.Constant) and first.slice.value is ...:
            array, kind = self.value(first.value)
            if not is_row(kind):
                raise self.refuse(node, "only a row can be filled")
            self.emit(f"fill({array}, {cast(self.value(node.value), self.owner.precision.real)});")
            return
        if self.is_whole(first) and len(node.targets) == 1:
            self.store(first, (self.whole(node.value), INTEGER))
            return
        text, kind = self.value(node.value)
        if len(node.targets) > 1 and not as_whole(text):
            text = self.temporary(kind, text)
        for target in node.targets:
            self.store(target, (text, kind))

    def do_augassign(self, node: ast.AugAssign) -> None:
        both = ast.BinOp(left=_loaded(node.target), op=node.op, right=node.value)
        before, self.exact = self.exact, self.exact or self.kept_exact(node.target)
        if self.is_whole(node.target):
            self.store(node.target, (self.whole(ast.copy_location(both, node)), INTEGER))
        else:
            self.store(node.target, self.value(ast.copy_location(both, node)))
        self.exact = before

    def do_if(self, node: ast.If) -> None:
        self.emit(f"if ({_bare(self.value(node.test)[0])}) {{")
        self.block(node.body)
        if node.orelse:
            self.emit("} else {")
            self.block(node.orelse)
        self.emit("}")

    def do_while(self, node: ast.While) -> None:
        if node.orelse:
            raise self.refuse(node, "while ... else has no translation")
        before = len(self.lines)
        test = self.value(node.test)[0]
        if len(self.lines) > before:
            raise self.refuse(node, "the condition of a loop must be one expression")
        self.emit(f"while ({_bare(test)}) {{")
        self.block(node.body)
        self.emit("}")

    def do_for(self, node: ast.For) -> None:
        call, target = node.iter, node.target
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "range"):
            raise self.refuse(node, "only `for name in range(...)` has a translation")
        if node.orelse or not isinstance(target, ast.Name):
            raise self.refuse(node, "only `for name in range(...)` has a translation")
        bounds = [self.value(part) for part in call.args]
        texts = [text for text, _ in bounds]
        start, stop, step = ("0LL", texts[0], "1LL") if len(texts) == 1 else (*texts, "1LL")[:3]
        down = step.lstrip("(").startswith("-")
        if target.id != "_":
            self.types.setdefault(target.id, INTEGER)
        counter = self.temporary(INTEGER, start)
        end = self.temporary(INTEGER, stop)
        self.emit(f"for (; {counter} {'>' if down else '<'} {end}; {counter} += {step}) {{")
        if target.id != "_":
            self.lines.append("    " * (self.depth + 1) + f"{self.local(target.id)} = {counter};")
        self.block(node.body)
        self.emit("}")

    def block(self, body: list[ast.stmt]) -> None:
        self.depth += 1
        for statement in body:
            self.statement(statement)
        self.depth -= 1

    def store(self, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            if isinstance(value[1], Layout):
                self.types[target.id] = value[1]
            if target.id != "_":
                self.emit(f"{self.local(target.id)} = {cast(value, self.types[target.id])};")
            return
        if isinstance(target, ast.Subscript):
            place, kind = self.value(target)
            if not is_scalar(kind):
                raise self.refuse(target, "only a number can be stored")
            if isinstance(kind, types.Integer):
                text = as_whole(value[0]) or value[0]
                self.emit(f"{place} = {text if kind == INTEGER or as_whole(text) else f'(int)({text})'};")
                return
            self.emit(f"{place} = {cast(value, kind)};")
            return
        raise self.refuse(target, "this place cannot be stored to")


def _loaded(target: ast.expr) -> ast.expr:
    """The same place, to be read."""
    return ast.parse(ast.unparse(target), mode="eval").body


def _bare(text: str) -> str:
    """A condition without brackets around all of it: clang takes them for a mistyped assignment."""
    depth = 0
    for k, sign in enumerate(text):
        depth += (sign == "(") - (sign == ")")
        if depth == 0:
            return _bare(text[1:-1]) if k == len(text) - 1 and text[0] == "(" else text
    return text
