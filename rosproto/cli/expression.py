"""Filter expressions typed by a person, evaluated by walking them: nothing is ever passed to eval.

The language is the harmless part of Python's expressions: literals, field access, indexing and slices,
arithmetic, comparison, `and`/`or`/`not`, `in`, conditional expressions, generator expressions over arrays,
and the functions of `FUNCTIONS`. `rostopic echo --filter` and `rosbag filter` take the same texts but
evaluate them with eval; here a text from a script or a web form can do no more than compute a value.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterable, Mapping

__all__ = ["FUNCTIONS", "Expression", "ExpressionError"]

MAX_TEXT = 4096
MAX_NODES = 500
MAX_STEPS = 2_000_000
MAX_EXPONENT = 1024
MAX_REPEAT = 1_000_000

FUNCTIONS: dict[str, Callable[..., object]] = {
    **{f.__name__: f for f in (abs, all, any, bool, float, int, len, max, min, round, sorted, str, sum)},
    **{name: getattr(math, name) for name in (
        "acos asin atan atan2 ceil copysign cos degrees exp fabs floor fmod hypot "
        "isfinite isinf isnan log log10 log2 radians sin sqrt tan"
    ).split()},
}  # fmt: skip
CONSTANTS: dict[str, object] = {"pi": math.pi, "inf": math.inf, "nan": math.nan}
STRING_METHODS = frozenset("startswith endswith lower upper strip split find count".split())

BINARY: dict[type[ast.operator], Callable[..., object]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.RShift: operator.rshift,
}
UNARY: dict[type[ast.unaryop], Callable[..., object]] = {
    ast.Not: operator.not_,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Invert: operator.invert,
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
    """An expression is not part of the language, or cannot be computed for this message.

    Attributes:
        text: The expression.
        column: Where, from 1; None when the whole text is meant.
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
        names: Names the caller will supply ("m", "topic", "t").

    Raises:
        ExpressionError: The text is not in the language; says where and what is allowed.
    """

    def __init__(self, text: str, names: Iterable[str] = ("m",)) -> None:
        self.text = text
        self.names = frozenset(names)
        if len(text) > MAX_TEXT:
            raise ExpressionError(f"longer than {MAX_TEXT} characters", text[:40] + "…")
        try:
            tree = ast.parse(text.strip(), mode="eval")
        except SyntaxError as error:
            raise ExpressionError(f"not a Python expression: {error.msg}", text, error.offset) from None
        except (ValueError, RecursionError, MemoryError) as error:
            raise ExpressionError(f"not a Python expression: {error}", text) from None
        nodes = list(ast.walk(tree.body))
        if len(nodes) > MAX_NODES:
            raise ExpressionError(f"more than {MAX_NODES} parts", text)
        self._root = tree.body
        self._check(nodes)

    def __call__(self, **values: object) -> object:
        """The expression's value for these values of its names.

        Raises:
            ExpressionError: A field does not exist, types do not fit, or it computes too long.
        """
        try:
            return _Walk(self.text, values).value(self._root)
        except ExpressionError:
            raise
        except Exception as error:  # whatever a value's own operator raises is the filter's error
            raise ExpressionError(f"{type(error).__name__}: {error}", self.text) from error

    def __repr__(self) -> str:
        return f"Expression({self.text!r})"

    def _check(self, nodes: list[ast.AST]) -> None:
        """Refuse what can never be evaluated when it is typed, not at the first message."""
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
            if isinstance(node, ast.Attribute) and node.attr.startswith("_"):
                raise ExpressionError(f"{node.attr!r} is not a field", self.text, column)
            if isinstance(node, ast.BinOp) and type(node.op) not in BINARY:
                raise ExpressionError(f"operator {type(node.op).__name__} is not allowed", self.text, column)


class _Walk:
    """One evaluation: the values, the names bound by comprehensions, and a bound on the work."""

    HANDLED = (
        ast.Constant, ast.Name, ast.Attribute, ast.Subscript, ast.Slice, ast.BinOp, ast.UnaryOp, ast.BoolOp,
        ast.Compare, ast.IfExp, ast.Call, ast.Tuple, ast.List, ast.GeneratorExp, ast.ListComp,
    )  # fmt: skip

    def __init__(self, text: str, values: Mapping[str, object]) -> None:
        self.text = text
        self.scope: dict[str, object] = {**CONSTANTS, **values}
        self.steps = 0

    def value(self, node: ast.AST) -> object:
        self.steps += 1
        if self.steps > MAX_STEPS:
            raise ExpressionError("takes too many steps for one message", self.text)
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
        return self.value(node.value)[self.value(node.slice)]  # type: ignore[index]

    def _slice(self, node: ast.Slice) -> slice:
        return slice(
            *(None if part is None else self.value(part) for part in (node.lower, node.upper, node.step))
        )

    def _binop(self, node: ast.BinOp) -> object:
        left, right = self.value(node.left), self.value(node.right)
        if isinstance(node.op, ast.Pow) and (_too_big(left) or _too_big(right)):
            raise ExpressionError("numbers this large are not raised to a power", self.text)
        if isinstance(node.op, ast.Mult) and any(hasattr(x, "__len__") for x in (left, right)):
            factor = right if hasattr(left, "__len__") else left
            if isinstance(factor, int) and factor > MAX_REPEAT:
                raise ExpressionError("a sequence is not repeated this often", self.text)
        return BINARY[type(node.op)](left, right)

    def _unaryop(self, node: ast.UnaryOp) -> object:
        return UNARY[type(node.op)](self.value(node.operand))

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
            result = COMPARE[type(op)](left, right)
            if not result:
                break
            left = right
        return result

    def _ifexp(self, node: ast.IfExp) -> object:
        return self.value(node.body if self.value(node.test) else node.orelse)

    def _tuple(self, node: ast.Tuple) -> object:
        return tuple(self.value(part) for part in node.elts)

    def _list(self, node: ast.List) -> object:
        return [self.value(part) for part in node.elts]

    def _call(self, node: ast.Call) -> object:
        if node.keywords:
            raise ExpressionError("keyword arguments are not allowed", self.text, node.col_offset + 1)
        arguments = [self.value(part) for part in node.args]
        if isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS and node.func.id not in self.scope:
            return FUNCTIONS[node.func.id](*arguments)
        if isinstance(node.func, ast.Attribute):
            owner = self.value(node.func.value)
            if isinstance(owner, str) and node.func.attr in STRING_METHODS:
                return getattr(owner, node.func.attr)(*arguments)
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
            found.append(self.value(element))
            return
        first, *rest = generators
        if not isinstance(first.target, ast.Name):
            raise ExpressionError("a loop takes one name", self.text)
        outer = dict(self.scope)
        for item in self.value(first.iter):  # type: ignore[attr-defined]
            self.scope[first.target.id] = item
            if all(self.value(test) for test in first.ifs):
                self._loop(rest, element, found)
        self.scope = outer


def _too_big(value: object) -> bool:
    return isinstance(value, int) and abs(value) > MAX_EXPONENT
