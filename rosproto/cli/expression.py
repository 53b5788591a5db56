"""Filter expressions typed by a person, evaluated by walking the syntax tree, without eval.

The language is a safe subset of Python's expressions: literals, field access, indexing and slices,
arithmetic, comparison, `and`/`or`/`not`, `in`, conditional expressions, generator expressions over arrays,
and the functions of `FUNCTIONS`. `rostopic echo --filter` and `rosbag filter` evaluate the same texts
with eval; here an untrusted text can only compute a value, within the limits of `expression_sandbox`.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rosproto.typed_values import expression_tree

from .expression_sandbox import FUNCTIONS, STRING_METHODS, Bounds, LimitExceeded

MAX_TEXT = 4096
MAX_NODES = 500
MAX_DEPTH = 60
MAX_CONSTANT_BITS = 4096

CONSTANTS: dict[str, object] = {"pi": math.pi, "inf": math.inf, "nan": math.nan}

BINARY: dict[type[ast.operator], str] = {
    ast.Add: "add",
    ast.Sub: "sub",
    ast.Mult: "mul",
    ast.Div: "truediv",
    ast.FloorDiv: "floordiv",
    ast.Mod: "mod",
    ast.Pow: "pow",
    ast.BitAnd: "and_",
    ast.BitOr: "or_",
    ast.BitXor: "xor",
    ast.RShift: "rshift",
}
UNARY: dict[type[ast.unaryop], str] = {
    ast.Not: "not_",
    ast.USub: "neg",
    ast.UAdd: "pos",
    ast.Invert: "invert",
}
COMPARE: dict[type[ast.cmpop], Callable[..., object]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
}


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
        self.names = frozenset(names)
        if len(text) > MAX_TEXT:
            raise ExpressionError(f"longer than {MAX_TEXT} characters", text[:40] + "…")
        try:
            root = expression_tree(text)
        except SyntaxError as error:
            raise ExpressionError(f"not a Python expression: {error.msg}", text, error.offset) from None
        except (ValueError, RecursionError, MemoryError) as error:
            raise ExpressionError(f"not a Python expression: {error}", text) from None
        nodes = list(ast.walk(root))
        if len(nodes) > MAX_NODES:
            raise ExpressionError(f"more than {MAX_NODES} parts", text)
        if _depth(root) > MAX_DEPTH:
            raise ExpressionError(f"more than {MAX_DEPTH} parts inside one another", text)
        self._root = root
        self._check(nodes)

    def __call__(self, **values: object) -> object:
        """Evaluate the expression for these values of its names.

        Raises:
            ExpressionError: A field does not exist, types do not match, or a limit is exceeded.
        """
        import numpy as np  # late: `--help` does without it

        try:
            with np.errstate(
                all="ignore"
            ):  # a division by zero is inf or nan, and no warning on the terminal
                return _Walk(self.text, values).value(self._root)
        except ExpressionError:
            raise
        except LimitExceeded as error:
            raise ExpressionError(str(error), self.text) from None
        except Exception as error:  # any error of a value's operator is an error of the filter
            raise ExpressionError(f"{type(error).__name__}: {error}", self.text) from error

    def _check(self, nodes: list[ast.AST]) -> None:
        """Refuse invalid expressions when they are parsed, not at the first message."""
        bound = set(self.names) | set(FUNCTIONS) | set(CONSTANTS)
        for node in nodes:
            if isinstance(node, ast.comprehension):
                bound |= {n.id for n in ast.walk(node.target) if isinstance(n, ast.Name)}
        for node in nodes:
            column = getattr(node, "col_offset", -1) + 1 or None
            if isinstance(
                node, (ast.expr_context, ast.operator, ast.unaryop, ast.cmpop, ast.boolop, ast.keyword)
            ):
                continue
            if not isinstance(node, (ast.comprehension, *_Walk.HANDLED)):
                raise ExpressionError(f"{type(node).__name__} is not allowed here", self.text, column)
            if isinstance(node, ast.Name) and node.id not in bound:
                known = ", ".join(sorted(self.names))
                raise ExpressionError(f"unknown name {node.id!r}; the message is {known}", self.text, column)
            if isinstance(node, ast.Constant) and _is_long(node.value):
                raise ExpressionError("integers have 4096 bits at most", self.text, column)
            if isinstance(node, ast.Attribute) and node.attr.startswith("_"):
                raise ExpressionError(f"{node.attr!r} is not a field", self.text, column)
            if isinstance(node, ast.BinOp) and type(node.op) not in BINARY:
                raise ExpressionError(f"operator {type(node.op).__name__} is not allowed", self.text, column)


class _Walk:
    """One evaluation: the values, the names bound by comprehensions, and the limits."""

    HANDLED = (
        ast.Constant, ast.Name, ast.Attribute, ast.Subscript, ast.Slice, ast.BinOp, ast.UnaryOp, ast.BoolOp,
        ast.Compare, ast.IfExp, ast.Call, ast.Tuple, ast.List, ast.GeneratorExp, ast.ListComp,
    )  # fmt: skip

    def __init__(self, text: str, values: Mapping[str, object]) -> None:
        self.text = text
        self.scope: dict[str, object] = {**CONSTANTS, **values}
        self.bounds = Bounds()

    def value(self, node: ast.AST) -> Any:
        self.bounds.spend(1)
        method = getattr(self, "_" + type(node).__name__.lower())
        return method(node)

    def _constant(self, node: ast.Constant) -> object:
        return node.value

    def _name(self, node: ast.Name) -> object:
        if node.id in self.scope:
            return self.scope[node.id]
        raise ExpressionError(f"{node.id!r} is a function: call it", self.text, node.col_offset + 1)

    def _attribute(self, node: ast.Attribute) -> object:
        owner = self.value(node.value)
        slots = getattr(type(owner), "__slots__", ())
        if node.attr in slots or (
            hasattr(type(owner), "_slot_types") and node.attr.isupper() and hasattr(owner, node.attr)
        ):
            return getattr(owner, node.attr)
        if hasattr(owner, "to_nsec") and node.attr in ("to_sec", "to_nsec"):
            return getattr(owner, node.attr)
        kind = getattr(owner, "_type", type(owner).__name__)
        fields = ", ".join(slots) if slots else "none"
        raise ExpressionError(f"{kind} has no field {node.attr!r}; it has: {fields}", self.text)

    def _subscript(self, node: ast.Subscript) -> object:
        return self.bounds.item(self.value(node.value), self.value(node.slice))

    def _slice(self, node: ast.Slice) -> slice:
        return slice(
            *(None if part is None else self.value(part) for part in (node.lower, node.upper, node.step))
        )

    def _binop(self, node: ast.BinOp) -> object:
        return self.bounds.binary(BINARY[type(node.op)], self.value(node.left), self.value(node.right))

    def _unaryop(self, node: ast.UnaryOp) -> object:
        return self.bounds.unary(UNARY[type(node.op)], self.value(node.operand))

    def _boolop(self, node: ast.BoolOp) -> object:
        stop_at = isinstance(node.op, ast.Or)
        result: object = None
        for part in node.values:
            result = self.value(part)
            if bool(result) is stop_at:
                break
        return result

    def _compare(self, node: ast.Compare) -> object:
        left = self.value(node.left)
        result: object = True
        for op, right_node in zip(node.ops, node.comparators, strict=True):
            right = self.value(right_node)
            result = self.bounds.compare(COMPARE[type(op)], left, right)
            if op is node.ops[-1] or not result:
                break  # the last may be an array of bools, for any() and all()
            left = right
        return result

    def _ifexp(self, node: ast.IfExp) -> object:
        return self.value(node.body if self.value(node.test) else node.orelse)

    def _tuple(self, node: ast.Tuple) -> object:
        return tuple(self.bounds.element(self.value(part)) for part in node.elts)

    def _list(self, node: ast.List) -> object:
        return [self.bounds.element(self.value(part)) for part in node.elts]

    def _call(self, node: ast.Call) -> object:
        if node.keywords:
            raise ExpressionError("keyword arguments are not allowed", self.text, node.col_offset + 1)
        arguments = [self.value(part) for part in node.args]
        if isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS and node.func.id not in self.scope:
            return self.bounds.call(node.func.id, arguments)
        if isinstance(node.func, ast.Attribute):
            owner = self.value(node.func.value)
            if isinstance(owner, str) and node.func.attr in STRING_METHODS:
                return self.bounds.method(owner, node.func.attr, arguments)
            if hasattr(owner, "to_nsec") and node.func.attr in ("to_sec", "to_nsec") and not arguments:
                return getattr(owner, node.func.attr)()
        raise ExpressionError(
            f"only these can be called: {', '.join(sorted(FUNCTIONS))}", self.text, node.col_offset + 1
        )

    def _generatorexp(self, node: ast.GeneratorExp | ast.ListComp) -> object:
        found: list[object] = []
        self._loop(node.generators, node.elt, found)
        return found

    _listcomp = _generatorexp

    def _loop(self, generators: list[ast.comprehension], element: ast.expr, found: list[object]) -> None:
        if not generators:
            found.append(self.bounds.element(self.value(element)))
            return
        first, *rest = generators
        if not isinstance(first.target, ast.Name):
            raise ExpressionError("a loop takes one name", self.text)
        outer = dict(self.scope)
        for item in self.value(first.iter):
            self.scope[first.target.id] = item
            if all(self.value(test) for test in first.ifs):
                self._loop(rest, element, found)
        self.scope = outer


def _is_long(value: object) -> bool:
    return isinstance(value, int) and value.bit_length() > MAX_CONSTANT_BITS


def _depth(node: ast.AST) -> int:
    """Return the nesting depth, without recursion."""
    level, depth = [node], 0
    while level:
        depth += 1
        level = [child for one in level for child in ast.iter_child_nodes(one)]
    return depth
