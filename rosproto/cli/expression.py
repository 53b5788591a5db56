"""Filter expressions typed by a person: a part of Python's expressions, compiled once, without builtins.

The language is literals, fields, indexing and slices, arithmetic, comparison, `and`/`or`/`not`, `in`,
conditional expressions, loops over arrays, and the functions of `FUNCTIONS`. `rostopic echo --filter` and
`rosbag filter` evaluate the same texts with all of Python. Time and memory are not limited: the text is the
user's own.
"""

from __future__ import annotations

import ast
import math
import warnings
from collections.abc import Callable, Iterable
from typing import Any

from rosproto.typed_values import expression_tree

FUNCTIONS: dict[str, Callable[..., object]] = {
    **{f.__name__: f for f in (abs, all, any, bool, float, int, len, max, min, round, sorted, str, sum)},
    **{name: getattr(math, name) for name in (
        "acos asin atan atan2 ceil copysign cos degrees exp fabs floor fmod hypot "
        "isfinite isinf isnan log log10 log2 radians sin sqrt tan"
    ).split()},
}  # fmt: skip
METHODS = frozenset("startswith endswith lower upper strip split find count to_sec to_nsec".split())
"""Methods of texts and of times."""
CONSTANTS: dict[str, object] = {"pi": math.pi, "inf": math.inf, "nan": math.nan}

_OPERATORS = (
    ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow, ast.BitAnd, ast.BitOr, ast.BitXor,
    ast.RShift,
)  # fmt: skip
_LANGUAGE = (
    ast.Constant, ast.Name, ast.Attribute, ast.Subscript, ast.Slice, ast.BinOp, ast.UnaryOp, ast.BoolOp,
    ast.Compare, ast.IfExp, ast.Call, ast.Tuple, ast.List, ast.GeneratorExp, ast.ListComp, ast.comprehension,
    ast.expr_context, ast.unaryop, ast.cmpop, ast.boolop, *_OPERATORS,
)  # fmt: skip


class ExpressionError(ValueError):
    """An expression is invalid, or cannot be computed for this message.

    Attributes:
        text: The expression.
        column: Position, from 1; None for the whole text.
    """

    def __init__(self, message: str, text: str, column: int | None = None) -> None:
        at = "" if column is None else f", column {column}"
        super().__init__(f"filter {text!r}{at}: {message}")
        self.text = text
        self.column = column


class Expression:
    """A parsed expression over named values.

    Args:
        text: For example `"m.pose.pose.position.x > 1.5 and m.header.frame_id == 'map'"`.
        names: Names the caller supplies ("m", "topic", "t").

    Raises:
        ExpressionError: The text is invalid; the error has the position and the allowed parts.
    """

    def __init__(self, text: str, names: Iterable[str] = ("m",)) -> None:
        self.text = text
        try:
            root = _Checked(text, frozenset(names)).visit(expression_tree(text))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of Python about style, such as `m.x is 1`
                self._code = compile(ast.fix_missing_locations(ast.Expression(root)), "<filter>", "eval")
        except ExpressionError:
            raise
        except SyntaxError as error:
            raise ExpressionError(f"not a Python expression: {error.msg}", text, error.offset) from None
        except (ValueError, RecursionError, MemoryError) as error:
            raise ExpressionError(f"not a Python expression: {error}", text) from None
        self._scope: dict[str, object] = {**FUNCTIONS, **CONSTANTS, "__builtins__": {}}
        self._scope.update({".field": _field, ".method": _method, ".element": _element})

    def __call__(self, **values: object) -> object:
        """Evaluate the expression for these values of its names.

        Raises:
            ExpressionError: A field does not exist, or types do not match.
        """
        import numpy as np  # late: `--help` does without it

        try:
            with np.errstate(all="ignore"):  # inf or nan, and no warning on the terminal
                return eval(self._code, {**self._scope, **values})
        except _NoField as error:
            raise ExpressionError(str(error), self.text) from None
        except Exception as error:  # any error of a value's operator is an error of the filter
            raise ExpressionError(f"{type(error).__name__}: {error}", self.text) from error


class _Checked(ast.NodeTransformer):
    """Refuses what is outside the language; fields and methods are looked up by the functions below.

    Their names begin with a dot, so that no text contains them.
    """

    def __init__(self, text: str, names: frozenset[str]) -> None:
        self.text = text
        self.names = names
        self.loops: set[str] = set()

    def visit(self, node: ast.AST) -> Any:
        if not isinstance(node, _LANGUAGE):
            raise self._wrong(node, f"{type(node).__name__} is not allowed here")
        return super().visit(node)

    def visit_Name(self, node: ast.Name) -> ast.AST:
        if node.id in FUNCTIONS and node.id not in self.names:
            raise self._wrong(node, f"{node.id!r} is a function: call it")
        if node.id not in self.names | self.loops and node.id not in CONSTANTS:
            known = ", ".join(sorted(self.names))
            raise self._wrong(node, f"unknown name {node.id!r}; the message is {known}")
        return node

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        return self._looked_up(".field", node)

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        if not isinstance(node.op, _OPERATORS):
            raise self._wrong(node, f"operator {type(node.op).__name__} is not allowed")
        return self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        if node.keywords:
            raise self._wrong(node, "keyword arguments are not allowed")
        called = node.func
        if isinstance(called, ast.Attribute) and called.attr in METHODS:
            called = self._looked_up(".method", called)
        elif not isinstance(called, ast.Name) or called.id not in FUNCTIONS:
            self.visit(called)  # an unknown name is said to be unknown
            raise self._wrong(node, f"only these can be called: {', '.join(sorted(FUNCTIONS))}")
        return ast.Call(called, [self.visit(value) for value in node.args], [])

    def visit_GeneratorExp(self, node: ast.GeneratorExp | ast.ListComp) -> ast.AST:
        """Make a list, which is false when it is empty."""
        for loop in node.generators:
            if not isinstance(loop.target, ast.Name) or loop.target.id in FUNCTIONS:
                raise self._wrong(loop.target, "a loop must have exactly one variable")
            self.loops.add(loop.target.id)
        loops = [self.visit(loop) for loop in node.generators]
        return ast.ListComp(_called(".element", self.visit(node.elt)), loops)

    visit_ListComp = visit_GeneratorExp

    def visit_List(self, node: ast.List | ast.Tuple) -> ast.AST:
        return type(node)([_called(".element", self.visit(value)) for value in node.elts], ast.Load())

    visit_Tuple = visit_List

    def _looked_up(self, function: str, node: ast.Attribute) -> ast.expr:
        if node.attr.startswith("_"):
            raise self._wrong(node, f"{node.attr!r} is not a field")
        return _called(function, self.visit(node.value), ast.Constant(node.attr))

    def _wrong(self, node: ast.AST, message: str) -> ExpressionError:
        return ExpressionError(message, self.text, getattr(node, "col_offset", -1) + 1 or None)


def _called(function: str, *arguments: ast.expr) -> ast.expr:
    return ast.Call(ast.Name(function, ast.Load()), list(arguments), [])


class _NoField(Exception):
    """The value has no such field."""


def _field(owner: object, name: str) -> object:
    """Return a field of a message, or a constant of its class."""
    fields = getattr(type(owner), "__slots__", ())
    if name in fields or (hasattr(type(owner), "_slot_types") and name.isupper() and hasattr(owner, name)):
        return getattr(owner, name)
    kind = getattr(owner, "_type", type(owner).__name__)
    raise _NoField(f"{kind} has no field {name!r}; it has: {', '.join(fields) or 'none'}")


def _method(owner: object, name: str) -> object:
    """Return a method of a text or a time."""
    if isinstance(owner, str) or hasattr(owner, "to_nsec"):
        return getattr(owner, name)
    raise _NoField(f"{getattr(owner, '_type', type(owner).__name__)} has no method {name!r}")


def _element(value: Any) -> object:
    """Return the element of a list: an array as a list, because numpy would broadcast it when compared."""
    return value.tolist() if hasattr(value, "dtype") and value.ndim else value
