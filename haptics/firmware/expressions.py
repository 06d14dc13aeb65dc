"""Expressions of compiled Python to C99: arithmetic, comparisons, elements, fields, and calls."""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
from collections.abc import Callable
from types import ModuleType
from typing import Any, Protocol

from numba.core import types
from numba.core.dispatcher import Dispatcher

from delta_cad.common.jit import Compiled
from haptics.firmware.inference import REASON, inferred, of_kind, plain, reasons, variables
from haptics.firmware.layout import WIDE, c_type, is_record, is_row, is_scalar, is_table, letter, record_name
from haptics.firmware.literals import Value, as_whole, cast, literal
from haptics.firmware.memories import LAID, RESERVED, Layout, Member
from haptics.firmware.precision import INTEGER, REAL, SINGLE, Precision

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


class TranslationError(ValueError):
    """Python that has no translation; the message names function and line."""


class Owner(Protocol):
    """What translates the functions that an expression calls, and defines the structs that it needs."""

    precision: Precision

    def add(self, function: Any, arguments: tuple[Any, ...]) -> tuple[str, Any]:
        """Name in C and return type of a function, translated now if it is not yet."""
        ...

    def record(self, kind: Any) -> None:
        """Defines the struct of a record or tuple."""
        ...


class Expressions:
    """A function on its way to C: its types, its names, and its expressions."""

    def __init__(self, owner: Owner, function: Any, arguments: tuple[Any, ...]) -> None:
        self.owner, self.python = owner, function.py_func
        precision = owner.precision
        self.real, self.exact = precision.of_function(function), False
        typemap, returns = inferred(self.python, tuple(map(plain, arguments)))
        self.returns = of_kind(returns, self.real)
        self.types = {name: of_kind(kind, self.real) for name, kind in variables(typemap).items()}
        self.scope = inspect.getclosurevars(self.python)
        source = getattr(self.python, "source", None) or textwrap.dedent(inspect.getsource(self.python))
        self.reasons = reasons(source)
        tree = ast.parse(source)
        self.tree = next(node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
        self.arguments = [argument.arg for argument in self.tree.args.args]
        for name, kind in zip(self.arguments, arguments, strict=True):
            self.types[name] = of_kind(kind, precision.of_argument(name, function))
        self.lines: list[str] = []
        self.depth, self.temporaries = 1, 0
        for kind in arguments:
            if is_record(kind):
                owner.record(kind)
        if isinstance(self.returns, types.BaseTuple):
            owner.record(self.returns)

    def refuse(self, node: ast.AST, what: str) -> TranslationError:
        """The error for a place in the function that has no translation."""
        line = getattr(node, "lineno", 0) + self.python.__code__.co_firstlineno - 1
        return TranslationError(f"{self.python.__module__}.{self.python.__name__}, line {line}: {what}")

    def emit(self, text: str) -> None:
        """Adds a line of C at the present depth."""
        self.lines.append("    " * self.depth + text)

    def local(self, name: str) -> str:
        """Name of a variable in C."""
        return name + "_" if name in RESERVED else name

    def temporary(self, kind: Any, text: str) -> str:
        """Adds a new variable that holds a value; its name."""
        self.temporaries += 1
        name = f"t{self.temporaries}_"
        self.emit(f"{c_type(kind)} {name} = {text};")
        return name

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
            if any(a != b for (_, a), (_, b) in zip(yes, no, strict=True)):
                raise self.refuse(node, "both sides must be of the same kinds")
            return [(f"({test} ? {a} : {b})", kind) for (a, kind), (b, _) in zip(yes, no, strict=True)]
        text, kind = self.value(node)
        if isinstance(kind, types.BaseTuple) and len(kind) == count:
            name = self.temporary(kind, text)
            return [(f"{name}.v{k}", part) for k, part in enumerate(tuple(kind))]  # pyright: ignore
        raise self.refuse(node, f"{kind} cannot be taken apart into {count}")

    def value(self, node: ast.expr) -> Value:
        """C text and type of an expression."""
        handler: Callable[[Any], Value] | None = getattr(self, f"of_{type(node).__name__.lower()}", None)
        if handler is None:
            raise self.refuse(node, f"{type(node).__name__} has no translation")
        return handler(node)

    def exactly(self, node: ast.expr) -> Value:
        """A value whose constants and fields are double."""
        before, self.exact = self.exact, True
        try:
            return self.value(node)
        finally:
            self.exact = before

    @property
    def written(self) -> Any:
        """Kind of constants and fields here."""
        return REAL if self.exact else self.real

    def joined(self, *nodes: ast.expr) -> tuple[list[str], Any]:
        """Values that meet in an operation: all of one kind, the widest, and that kind."""
        mark, count = len(self.lines), self.temporaries
        values = [self.value(node) for node in nodes]
        kinds = {kind for _, kind in values}
        if REAL in kinds and SINGLE in kinds:
            del self.lines[mark:]
            self.temporaries = count
            values = [self.exactly(node) for node in nodes]
        kind = next((kind for kind in (REAL, SINGLE) if kind in kinds), None)
        if kind is None and any(isinstance(part, types.Float) for part in kinds):
            raise self.refuse(nodes[0], "a real number of another kind")
        if kind is None:
            return [text for text, _ in values], INTEGER
        return [cast(value, kind) for value in values], kind

    def of_constant(self, node: ast.Constant) -> Value:
        """A number written out."""
        return self.constant(node, node.value)

    def constant(self, node: ast.AST, value: Any) -> Value:
        """A number from the function's text or from a module, written out."""
        if isinstance(value, bool):
            return literal(value), types.boolean
        if isinstance(value, int):  # IntEnum members too
            return literal(int(value)), INTEGER
        if isinstance(value, float):
            return literal(value, self.written), self.written
        raise self.refuse(node, f"{value!r} is no number")

    def named(self, node: ast.expr, name: str) -> Value:
        """A constant from outside: its number, and its name for whoever reads the code."""
        text, kind = self.constant(node, self.outside(node))
        return f"{text} /* {name.lstrip('_')} */", kind

    def whole(self, node: ast.expr) -> str:
        """C text of a whole number, which Python may compute as a float."""
        if isinstance(node, ast.IfExp):
            return f"({self.value(node.test)[0]} ? {self.whole(node.body)} : {self.whole(node.orelse)})"
        if isinstance(node, ast.Call) and self.outside(node.func) is float:
            return self.whole(node.args[0])
        if isinstance(node, ast.BinOp) and type(node.op) in (ast.Add, ast.Sub, ast.BitOr, ast.BitAnd):
            return f"({self.whole(node.left)} {OPERATORS[type(node.op)]} {self.whole(node.right)})"
        text, kind = self.value(node)
        return as_whole(text) or (text if isinstance(kind, types.Integer | types.Boolean) else f"((long long)({text}))")

    def of_name(self, node: ast.Name) -> Value:
        """A local variable, or a constant from outside."""
        if node.id in self.types:
            return self.local(node.id), self.types[node.id]
        return self.named(node, node.id)

    def outside(self, node: ast.expr) -> Any:
        """The value of a name or a module's attribute outside the function."""
        if isinstance(node, ast.Name):
            for known in (self.scope.nonlocals, self.scope.globals, self.scope.builtins):
                if node.id in known:
                    return known[node.id]
        if isinstance(node, ast.Attribute):
            owner = self.outside(node.value)
            if isinstance(owner, ModuleType):
                return getattr(owner, node.attr)
        raise self.refuse(node, f"{ast.unparse(node)} is not known")

    def of_attribute(self, node: ast.Attribute) -> Value:
        """A field of a record, or a constant of a module."""
        if isinstance(node.value, ast.Name) and node.value.id not in self.types:
            return self.named(node, node.attr)
        text, kind = self.value(node.value)
        if not is_record(kind):
            raise self.refuse(node, f"{kind} has no fields")
        laid = LAID.get((record_name(kind), node.attr))
        if laid:
            return f"{text}->{node.attr}", laid
        part = dict(zip(kind.fields, kind.types, strict=True))[node.attr]
        place = f"{text}->{node.attr}"
        if is_record(part):
            return f"(&{place})", part
        wide = isinstance(part, types.Float) and self.owner.precision.single and self.written == REAL
        return (f"{place}{WIDE}" if wide else place), of_kind(part, self.written)

    def of_subscript(self, node: ast.Subscript) -> Value:
        """An element or a part of an array, or its size along an axis."""
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            text, kind = self.value(node.value.value)
            which = ast.literal_eval(node.slice)
            if is_row(kind) and which == 0:
                return f"{text}.n", INTEGER
            if is_table(kind) and which in (0, 1):
                return f"{text}.{('rows', 'columns')[which]}", INTEGER
            raise self.refuse(node, "this array has no such axis")
        text, kind = self.value(node.value)
        if isinstance(kind, Layout):
            return self.member(node, text, kind)
        if is_row(kind) and isinstance(node.slice, ast.Slice):
            return f"part({text}, {self.ends(node.slice)})", kind
        if is_table(kind) and isinstance(node.slice, ast.Tuple):
            first, second = node.slice.elts
            if isinstance(first, ast.Slice) and isinstance(second, ast.Slice):
                return f"table_part({text}, {self.ends(first)}, {self.ends(second)})", kind
            if isinstance(second, ast.Slice):
                whole = f"row_of({text}, {self.value(first)[0]})"
                return f"part({whole}, {self.ends(second)})", types.Array(REAL, 1, "C")
        at = self.places(node.slice)
        if is_row(kind) and len(at) == 1:
            return f"{text}.at[{at[0]}]", self.owner.precision.real
        if is_table(kind) and len(at) == 1:
            return f"row_of({text}, {at[0]})", types.Array(REAL, 1, "C")
        if is_table(kind) and len(at) == 2:
            return f"{text}.at[({at[0]}) * {text}.stride + ({at[1]})]", self.owner.precision.real
        raise self.refuse(node, f"{kind} has no such element")

    def member(self, node: ast.Subscript, text: str, layout: Layout) -> Value:
        """A place of a memory: `mem[m.NAME]`, `mem[m.NAME + i]` or all of it, `mem[m.NAME : m.NAME + 3]`."""
        whole = isinstance(node.slice, ast.Slice)
        one, rest = self.place_of(node.slice.lower if isinstance(node.slice, ast.Slice) else node.slice, layout)
        place, kind = f"{text}->{one.c_name}", one.kind(self.owner.precision)
        if whole:
            return f"((row){{ {place}, {one.width}LL }})", types.Array(REAL, 1, "C")
        if one.width > 1:
            place += f"[{self.value(rest)[0] if rest else '0'}]"
        elif rest:
            raise self.refuse(node, f"{one.name} is one number")
        return place, kind

    def place_of(self, node: ast.expr | None, layout: Layout) -> tuple[Member, ast.expr | None]:
        """The place that an index begins with, and what is added to it."""
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            one, rest = self.place_of(node.left, layout)
            return one, ast.BinOp(rest, ast.Add(), node.right) if rest else node.right
        name = None
        if isinstance(node, ast.Attribute) and self.outside(node.value) is layout.module:
            name = node.attr
        if isinstance(node, ast.Name) and node.id not in self.types:
            name = node.id
        if name not in layout.members:
            raise self.refuse(node or self.tree, f"an index of {layout.struct} must begin with the name of a place")
        return layout.members[name], None

    def equality(self, node: ast.Compare, sides: list[str], kind: Any) -> list[str]:
        """Numbers that are equal: whole ones as such; real ones by `equal`, with the reason that the line must give."""
        nodes = [node.left, *node.comparators]
        mark = len(self.lines)
        kinds = [self.value(one)[1] for one in nodes]
        del self.lines[mark:]
        texts = [
            self.whole(one) if isinstance(own, types.Integer) else as_whole(text)
            for one, own, text in zip(nodes, kinds, sides, strict=True)
        ]
        if any(isinstance(own, types.Integer) for own in kinds) and None not in texts:
            pairs = zip(texts, node.ops, texts[1:], strict=False)
            return [f"({a} {OPERATORS[type(op)]} {b})" for a, op, b in pairs]
        reason = self.reasons.get(node.lineno)
        if reason is None:
            raise self.refuse(node, f"real numbers held to be equal need a reason at the line's end: # {REASON}why")
        self.emit(f"/* {REASON}{reason} */")
        pairs = zip(sides, node.ops, sides[1:], strict=False)
        return [f"{'!' * isinstance(op, ast.NotEq)}equal{letter(kind)}({a}, {b})" for a, op, b in pairs]

    def ends(self, node: ast.Slice) -> str:
        """C text of the ends of a slice; it begins with the first element if nothing is said."""
        if node.upper is None or node.step is not None:
            raise self.refuse(node, "a slice needs its end and no step")
        lower = "0LL" if node.lower is None else self.value(node.lower)[0]
        return f"{lower}, {self.value(node.upper)[0]}"

    def places(self, node: ast.expr) -> list[str]:
        """C text of the indices between brackets."""
        if isinstance(node, ast.Slice):
            return []
        if isinstance(node, ast.Tuple):
            return [self.value(part)[0] for part in node.elts]
        if isinstance(node, ast.Name) and node.id not in self.types and isinstance(self.outside(node), tuple):
            return [literal(part) for part in self.outside(node)]
        return [self.value(node)[0]]

    def of_binop(self, node: ast.BinOp) -> Value:
        """Arithmetic on two values."""
        if isinstance(node.op, ast.Pow):
            return self.power(node)
        (a, b), kind = self.joined(node.left, node.right)
        if isinstance(node.op, ast.Div):
            if kind == INTEGER:
                (a, b), kind = [cast((text, INTEGER), self.written) for text in (a, b)], self.written
            return f"({a} / {b})", kind
        if isinstance(node.op, ast.FloorDiv | ast.Mod) and kind == INTEGER:
            sign = "/" if isinstance(node.op, ast.FloorDiv) else "%"  # none of our whole numbers is negative
            return f"({a} {sign} {b})", INTEGER
        if type(node.op) not in OPERATORS:
            raise self.refuse(node, f"{ast.unparse(node)} has no translation")
        return f"({a} {OPERATORS[type(node.op)]} {b})", kind

    def power(self, node: ast.BinOp) -> Value:
        """A square or a cube, as the product that numba makes of it."""
        exponent = node.right.value if isinstance(node.right, ast.Constant) else None
        text, kind = self.value(node.left)
        if exponent not in (2, 3):
            raise self.refuse(node, "only squares and cubes have a translation")
        base = self.temporary(kind, text)
        return (f"({base} * {base})" if exponent == 2 else f"({base} * ({base} * {base}))"), kind

    def of_unaryop(self, node: ast.UnaryOp) -> Value:
        """A sign or a negation."""
        text, kind = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return f"(!({text}))", types.boolean
        if isinstance(node.op, ast.USub):
            return f"(-({text}))", kind
        if isinstance(node.op, ast.Invert):
            return f"(~({text}))", INTEGER
        raise self.refuse(node, f"{ast.unparse(node)} has no translation")

    def of_boolop(self, node: ast.BoolOp) -> Value:
        """Conditions joined by and, or."""
        sign = " && " if isinstance(node.op, ast.And) else " || "
        parts = [self.value(part) for part in node.values]
        return "(" + sign.join(text for text, _ in parts) + ")", types.boolean

    def of_compare(self, node: ast.Compare) -> Value:
        """A comparison, also a chain of them."""
        if isinstance(node.ops[0], ast.In) and isinstance(node.comparators[0], ast.Tuple):
            one = ast.copy_location
            tests = [one(ast.Compare(node.left, [ast.Eq()], [part]), node) for part in node.comparators[0].elts]
            return self.of_boolop(ast.BoolOp(ast.Or(), list(tests)))
        sides, kind = self.joined(node.left, *node.comparators)
        if all(isinstance(op, ast.Eq | ast.NotEq) for op in node.ops) and isinstance(kind, types.Float):
            tests = self.equality(node, sides, kind)
        else:
            tests = [f"({a} {OPERATORS[type(op)]} {b})" for a, op, b in zip(sides, node.ops, sides[1:], strict=False)]
        return "(" + " && ".join(tests) + ")", types.boolean

    def of_ifexp(self, node: ast.IfExp) -> Value:
        """A choice between two values."""
        test = self.value(node.test)[0]
        first = self.value(node.body)
        if not is_scalar(first[1]):
            return f"({test} ? {first[0]} : {self.value(node.orelse)[0]})", first[1]
        (a, b), kind = self.joined(node.body, node.orelse)
        return f"({test} ? {a} : {b})", kind

    def of_call(self, node: ast.Call) -> Value:
        """A call of another compiled function, or of a function that C has, too."""
        if node.keywords:
            raise self.refuse(node, "arguments by name have no translation")
        called = self.outside(node.func)
        if called in (math.isfinite, math.isnan, math.isinf):
            return f"({called.__name__}({self.value(node.args[0])[0]}) != 0)", types.boolean
        if isinstance(called, Dispatcher | Compiled):
            return self.of_own(node, called)
        if called in (min, max):
            texts, kind = self.joined(*node.args)
            name = f"{'' if isinstance(kind, types.Float) else 'i'}{called.__name__}2{letter(kind)}"
            text = texts[0]
            for other in texts[1:]:
                text = f"{name}({text}, {other})"
            return text, kind
        inner = node.args[0]
        if called is float and isinstance(inner, ast.Call) and self.outside(inner.func) is math.floor:
            text, kind = self.value(inner.args[0])  # without a way through a whole number, which costs a call each
            return f"delta_floor{letter(kind)}({text})", kind
        if called is float:
            return cast(self.value(node.args[0]), self.written), self.written
        values = [self.value(argument) for argument in node.args]
        text, kind = values[0]
        if called is abs:
            name = f"delta_fabs{letter(kind)}" if isinstance(kind, types.Float) else "llabs"
            return f"{name}({text})", kind
        if called is int:
            return (text if isinstance(kind, types.Integer) else f"((long long)({text}))"), INTEGER
        if called is math.floor:
            return f"((long long)delta_floor{letter(kind)}({text}))", INTEGER
        if called is len and is_row(kind):
            return f"{text}.n", INTEGER
        if getattr(called, "__module__", "") == "math" and called.__name__ in MATH:
            texts, kind = self.joined(*node.args)
            if kind == INTEGER:
                texts, kind = [cast((one, INTEGER), self.written) for one in texts], self.written
            own = "delta_" if called is math.sqrt else ""
            return f"{own}{called.__name__}{letter(kind)}({', '.join(texts)})", kind
        raise self.refuse(node, f"{ast.unparse(node.func)} has no translation")

    def of_own(self, node: ast.Call, called: Any) -> Value:
        """A call of another compiled function, whose arguments may be of another precision than ours."""
        values = [self.value(argument) for argument in node.args]
        name, returns = self.owner.add(
            called, tuple(kind if isinstance(kind, Layout) else plain(kind) for _, kind in values)
        )
        names = list(inspect.signature(called.py_func).parameters)
        texts = []
        for argument, value, own in zip(node.args, values, names, strict=True):
            if isinstance(value[1], types.Float):
                wanted = self.owner.precision.of_argument(own, called)
                value = self.exactly(argument) if wanted == REAL else value
                texts.append(cast(value, wanted))
            else:
                texts.append(value[0])
        return f"{name}({', '.join(texts)})", returns
