"""Compiled Python functions to C99: the part of the language that a tick is written in, and nothing else.

The functions are read as syntax trees; types come from numba's own inference, so that what is an integer there is one
here. Understood are arithmetic on doubles and integers, comparisons, conditions, `for ... in range`, `while`, tuples
that are taken apart at once, rows and tables of doubles, fields of NamedTuples, and calls of other compiled functions,
which are translated too. Constants of modules are written out. Anything else is refused, with function and line.

Floating point is kept as it is: same order of operations, no contraction (compile with `-ffp-contract=off`), squares
and cubes as the products that numba makes of them.
"""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
from collections.abc import Callable
from types import ModuleType
from typing import Any

from numba.core import types
from numba.core.dispatcher import Dispatcher

from delta_cad.common.jit import Compiled
from haptics.firmware.inference import inferred
from haptics.firmware.layout import c_type, is_record, is_row, is_scalar, is_table, record_name, struct, tuple_name

REAL = types.float64
WHOLE = types.int64
MATH = {"sqrt", "sin", "cos", "exp", "hypot", "atan2", "tan", "acos", "asin", "atan", "log", "log1p", "expm1"}
OPERATORS = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.BitOr: "|",
    ast.BitAnd: "&",
    ast.BitXor: "^",
    ast.LShift: "<<",
    ast.RShift: ">>",
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
}
RESERVED = {"double", "long", "int", "row", "table", "part", "fill", "short", "float", "register", "signed", "default"}


class TranslationError(ValueError):
    """Python that has no translation; the message names function and line."""


Value = tuple[str, Any]
"""C text and the compiler's type."""


class Translation:
    """C text of functions and of all that they need, in the order in which C wants it.

    Attributes:
        functions: C name -> definition.
        structs: C name -> definition.
    """

    def __init__(self) -> None:
        self.functions: dict[str, str] = {}
        self.structs: dict[str, str] = {}
        self._returns: dict[str, Any] = {}

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
        name = c_name(function)
        if name not in self.functions:
            written = _Function(self, function, arguments)
            text = written.text(name)
            self.functions[name] = text
            self._returns[name] = written.returns
        return name, self._returns[name]

    def record(self, kind: Any) -> None:
        """Defines the struct of a record or tuple, those inside it first."""
        name = record_name(kind) if is_record(kind) else tuple_name(kind)
        if name in self.structs:
            return
        for part in kind:
            if is_record(part):
                self.record(part)
        self.structs[name] = struct(kind)


def c_name(function: Dispatcher) -> str:
    """Name of a function in C: its module's last word and its own."""
    return f"{function.py_func.__module__.rsplit('.', 1)[-1]}_{function.py_func.__name__.strip('_')}"


def literal(value: float) -> str:
    """A number in C that reads back to the last bit."""
    if isinstance(value, bool | int):
        return f"{int(value)}LL"
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    return repr(float(value)) if value >= 0.0 else f"({float(value)!r})"


class _Function:
    """One function on its way to C."""

    def __init__(self, owner: Translation, function: Dispatcher, arguments: tuple[Any, ...]) -> None:
        self.owner, self.python = owner, function.py_func
        typemap, self.returns = inferred(self.python, arguments)
        self.types = _variables(typemap)
        self.scope = inspect.getclosurevars(self.python)
        tree = ast.parse(textwrap.dedent(inspect.getsource(self.python)))
        self.tree = next(node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
        self.arguments = [argument.arg for argument in self.tree.args.args]
        self.types.update(zip(self.arguments, arguments, strict=True))
        self.lines: list[str] = []
        self.depth, self.temporaries = 1, 0
        for kind in arguments:
            if is_record(kind):
                owner.record(kind)
        if isinstance(self.returns, types.BaseTuple):
            owner.record(self.returns)

    def text(self, name: str) -> str:
        """The definition."""
        for statement in self.tree.body:
            self.statement(statement)
        parts = [f"{c_type(self.types[a])} {self.local(a)}".replace("* ", "*") for a in self.arguments]
        head = f"{c_type(self.returns)} {name}({', '.join(parts)})"
        declared = [
            f"    {c_type(kind)} {self.local(variable)};".replace("* ", "*")
            for variable, kind in sorted(self.types.items())
            if variable not in self.arguments
        ]
        about = (self.python.__doc__ or "").strip().split("\n")[0]
        return "\n".join([f"/* {about} */", f"static {head}", "{", *declared, *self.lines, "}"]) + "\n"

    def refuse(self, node: ast.AST, what: str) -> TranslationError:
        line = getattr(node, "lineno", 0) + self.python.__code__.co_firstlineno - 1
        return TranslationError(f"{self.python.__module__}.{self.python.__name__}, line {line}: {what}")

    def emit(self, text: str) -> None:
        self.lines.append("    " * self.depth + text)

    def local(self, name: str) -> str:
        return name + "_" if name in RESERVED else name

    def temporary(self, kind: Any, text: str) -> str:
        self.temporaries += 1
        name = f"t{self.temporaries}_"
        self.emit(f"{c_type(kind)} {name} = {text};")
        return name

    # statements

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
            self.emit(f"return ({tuple_name(self.returns)}){{ {', '.join(text for text, _ in parts)} }};")
            return
        self.emit(f"return {self.value(node.value)[0]};")

    def do_assign(self, node: ast.Assign) -> None:
        first = node.targets[0]
        if isinstance(first, ast.Tuple):
            if len(node.targets) > 1:
                raise self.refuse(node, "a chain of tuples has no translation")
            parts = self.several(node.value, len(first.elts))
            if len(parts) > 1:  # all are taken before any is changed
                parts = [(self.temporary(kind, text), kind) for text, kind in parts]
            for target, (text, _) in zip(first.elts, parts, strict=True):
                self.store(target, text)
            return
        if isinstance(first, ast.Subscript) and isinstance(first.slice, ast.Constant) and first.slice.value is ...:
            array, kind = self.value(first.value)
            if not is_row(kind):
                raise self.refuse(node, "only a row can be filled")
            self.emit(f"fill({array}, {self.value(node.value)[0]});")
            return
        text, kind = self.value(node.value)
        if len(node.targets) > 1:
            text = self.temporary(kind, text)
        for target in node.targets:
            self.store(target, text)

    def do_augassign(self, node: ast.AugAssign) -> None:
        both = ast.BinOp(left=_loaded(node.target), op=node.op, right=node.value)
        self.store(node.target, self.value(ast.copy_location(both, node))[0])

    def do_if(self, node: ast.If) -> None:
        self.emit(f"if ({self.value(node.test)[0]}) {{")
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
        self.emit(f"while ({test}) {{")
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
            self.types.setdefault(target.id, WHOLE)
        counter = self.temporary(WHOLE, start)
        end = self.temporary(WHOLE, stop)
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

    def store(self, target: ast.expr, text: str) -> None:
        if isinstance(target, ast.Name):
            if target.id != "_":
                self.emit(f"{self.local(target.id)} = {text};")
            return
        if isinstance(target, ast.Subscript):
            place, kind = self.value(target)
            if not is_scalar(kind):
                raise self.refuse(target, "only a number can be stored")
            self.emit(f"{place} = {text};")
            return
        raise self.refuse(target, "this place cannot be stored to")

    # expressions

    def several(self, node: ast.expr, count: int) -> list[Value]:
        """The parts of a tuple."""
        if isinstance(node, ast.Tuple):
            if len(node.elts) != count:
                raise self.refuse(node, f"{len(node.elts)} values for {count} places")
            return [self.value(part) for part in node.elts]
        if isinstance(node, ast.IfExp):
            if any(isinstance(part, ast.Call) for part in (node.body, node.orelse)):
                raise self.refuse(node, "a call that is taken apart would run whether it is chosen or not")
            test, yes, no = self.value(node.test)[0], self.several(node.body, count), self.several(node.orelse, count)
            return [(f"({test} ? {a} : {b})", kind) for (a, kind), (b, _) in zip(yes, no, strict=True)]
        text, kind = self.value(node)
        if isinstance(kind, types.BaseTuple) and len(kind) == count:
            name = self.temporary(kind, text)
            return [(f"{name}.v{k}", part) for k, part in enumerate(tuple(kind))]  # pyright: ignore
        raise self.refuse(node, f"{kind} cannot be taken apart into {count}")

    def value(self, node: ast.expr) -> Value:
        handler: Callable[[Any], Value] | None = getattr(self, f"of_{type(node).__name__.lower()}", None)
        if handler is None:
            raise self.refuse(node, f"{type(node).__name__} has no translation")
        return handler(node)

    def of_constant(self, node: ast.Constant) -> Value:
        return self.constant(node, node.value)

    def constant(self, node: ast.AST, value: Any) -> Value:
        if isinstance(value, bool):
            return literal(value), types.boolean
        if isinstance(value, int):  # IntEnum members too
            return literal(int(value)), WHOLE
        if isinstance(value, float):
            return literal(value), REAL
        raise self.refuse(node, f"{value!r} is no number")

    def of_name(self, node: ast.Name) -> Value:
        if node.id in self.types:
            return self.local(node.id), self.types[node.id]
        return self.constant(node, self.outside(node))

    def outside(self, node: ast.expr) -> Any:
        """What a name or a module's attribute stands for, outside the function."""
        if isinstance(node, ast.Name):
            for known in (self.scope.globals, self.scope.builtins, self.scope.nonlocals):
                if node.id in known:
                    return known[node.id]
        if isinstance(node, ast.Attribute):
            owner = self.outside(node.value)
            if isinstance(owner, ModuleType):
                return getattr(owner, node.attr)
        raise self.refuse(node, f"{ast.unparse(node)} is not known")

    def of_attribute(self, node: ast.Attribute) -> Value:
        if isinstance(node.value, ast.Name) and node.value.id not in self.types:
            return self.constant(node, self.outside(node))
        text, kind = self.value(node.value)
        if not is_record(kind):
            raise self.refuse(node, f"{kind} has no fields")
        part = dict(zip(kind.fields, kind.types, strict=True))[node.attr]
        place = f"{text}->{node.attr}"
        return (f"(&{place})" if is_record(part) else place), part

    def of_subscript(self, node: ast.Subscript) -> Value:
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            text, kind = self.value(node.value.value)
            which = ast.literal_eval(node.slice)
            if is_row(kind) and which == 0:
                return f"{text}.n", WHOLE
            if is_table(kind) and which in (0, 1):
                return f"{text}.{('rows', 'columns')[which]}", WHOLE
            raise self.refuse(node, "this array has no such axis")
        text, kind = self.value(node.value)
        at = self.places(node.slice)
        if is_row(kind) and isinstance(node.slice, ast.Slice):
            if node.slice.lower is None or node.slice.upper is None or node.slice.step is not None:
                raise self.refuse(node, "a slice needs both ends and no step")
            return f"part({text}, {self.value(node.slice.lower)[0]}, {self.value(node.slice.upper)[0]})", kind
        if is_row(kind) and len(at) == 1:
            return f"{text}.at[{at[0]}]", REAL
        if is_table(kind) and len(at) == 1:
            return f"row_of({text}, {at[0]})", types.Array(REAL, 1, "C")
        if is_table(kind) and len(at) == 2:
            return f"{text}.at[({at[0]}) * {text}.columns + ({at[1]})]", REAL
        raise self.refuse(node, f"{kind} has no such element")

    def places(self, node: ast.expr) -> list[str]:
        if isinstance(node, ast.Slice):
            return []
        if isinstance(node, ast.Tuple):
            return [self.value(part)[0] for part in node.elts]
        if isinstance(node, ast.Name) and node.id not in self.types and isinstance(self.outside(node), tuple):
            return [literal(part) for part in self.outside(node)]
        return [self.value(node)[0]]

    def of_binop(self, node: ast.BinOp) -> Value:
        if isinstance(node.op, ast.Pow):
            return self.power(node)
        (a, left), (b, right) = self.value(node.left), self.value(node.right)
        real = isinstance(left, types.Float) or isinstance(right, types.Float)
        kind = REAL if real else WHOLE
        if isinstance(node.op, ast.Div):
            return f"((double)({a}) / (double)({b}))", REAL
        if isinstance(node.op, ast.FloorDiv | ast.Mod) and not real:
            sign = "/" if isinstance(node.op, ast.FloorDiv) else "%"  # none of our whole numbers is negative
            return f"({a} {sign} {b})", WHOLE
        if type(node.op) not in OPERATORS:
            raise self.refuse(node, f"{ast.unparse(node)} has no translation")
        return f"({a} {OPERATORS[type(node.op)]} {b})", kind

    def power(self, node: ast.BinOp) -> Value:
        exponent = node.right.value if isinstance(node.right, ast.Constant) else None
        text, kind = self.value(node.left)
        if exponent not in (2, 3):
            raise self.refuse(node, "only squares and cubes have a translation")
        base = self.temporary(kind, text)
        return (f"({base} * {base})" if exponent == 2 else f"({base} * ({base} * {base}))"), kind

    def of_unaryop(self, node: ast.UnaryOp) -> Value:
        text, kind = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return f"(!({text}))", types.boolean
        if isinstance(node.op, ast.USub):
            return f"(-({text}))", kind
        if isinstance(node.op, ast.Invert):
            return f"(~({text}))", WHOLE
        raise self.refuse(node, f"{ast.unparse(node)} has no translation")

    def of_boolop(self, node: ast.BoolOp) -> Value:
        sign = " && " if isinstance(node.op, ast.And) else " || "
        parts = [self.value(part) for part in node.values]
        return "(" + sign.join(text for text, _ in parts) + ")", types.boolean

    def of_compare(self, node: ast.Compare) -> Value:
        sides = [self.value(side)[0] for side in (node.left, *node.comparators)]
        tests = [f"({a} {OPERATORS[type(op)]} {b})" for a, op, b in zip(sides, node.ops, sides[1:], strict=False)]
        return "(" + " && ".join(tests) + ")", types.boolean

    def of_ifexp(self, node: ast.IfExp) -> Value:
        test = self.value(node.test)[0]
        (a, left), (b, right) = self.value(node.body), self.value(node.orelse)
        kind = left if not is_scalar(left) or isinstance(left, types.Float) else right
        return f"({test} ? {a} : {b})", kind

    def of_call(self, node: ast.Call) -> Value:
        if node.keywords:
            raise self.refuse(node, "arguments by name have no translation")
        called = self.outside(node.func)
        if called in (math.isfinite, math.isnan, math.isinf):
            return f"({called.__name__}({self.value(node.args[0])[0]}) != 0)", types.boolean
        if isinstance(called, Dispatcher | Compiled):
            values = [self.value(argument) for argument in node.args]
            name, returns = self.owner.add(called, tuple(_plain(kind) for _, kind in values))
            return f"{name}({', '.join(text for text, _ in values)})", returns
        values = [self.value(argument) for argument in node.args]
        texts = [text for text, _ in values]
        real = any(isinstance(kind, types.Float) for _, kind in values)
        if called in (min, max):
            name, kind = f"{'' if real else 'i'}{called.__name__}2", REAL if real else WHOLE
            text = texts[0]
            for other in texts[1:]:
                text = f"{name}({text}, {other})"
            return text, kind
        if called is abs:
            return (f"fabs({texts[0]})", REAL) if real else (f"llabs({texts[0]})", WHOLE)
        if called is int:
            return f"((long long)({texts[0]}))", WHOLE
        if called is float:
            return f"((double)({texts[0]}))", REAL
        if called is math.floor:
            return f"((long long)floor({texts[0]}))", WHOLE
        if called is len and is_row(values[0][1]):
            return f"{texts[0]}.n", WHOLE
        if getattr(called, "__module__", "") == "math" and called.__name__ in MATH:
            return f"{called.__name__}({', '.join(texts)})", REAL
        raise self.refuse(node, f"{ast.unparse(node.func)} has no translation")


def _variables(typemap: dict[str, Any]) -> dict[str, Any]:
    """Name of each local variable -> its type; a double where one of its versions is."""
    found: dict[str, Any] = {}
    for name, kind in typemap.items():
        variable = name.split(".")[0]
        if variable.startswith("$") or variable in ("arg", "_"):
            continue
        plain = _plain(kind)
        if not (is_scalar(plain) or is_row(plain) or is_table(plain) or is_record(plain)):
            continue
        if variable not in found or isinstance(plain, types.Float):
            found[variable] = plain
    return found


def _plain(kind: Any) -> Any:
    """A type without the compiler's knowledge of constants and alignment."""
    if isinstance(kind, types.Boolean | types.BooleanLiteral):
        return types.boolean
    if isinstance(kind, types.Integer | types.IntegerLiteral):
        return WHOLE
    if isinstance(kind, types.Array):
        return types.Array(kind.dtype, kind.ndim, "C")
    return kind


def _loaded(target: ast.expr) -> ast.expr:
    """The same place, to be read."""
    return ast.parse(ast.unparse(target), mode="eval").body
