"""Convert messages between revisions of their type, by field name.

Robots of different firmware have different definitions of a type. A `Conversion` is planned once for a pair
of classes and used for every message. Equal fields are passed on unchanged. Numbers of another width are
range-checked. Fields missing on one side are dropped or get their default. Planning refuses fields of another
kind (text or number, array or value, another message type).
"""

from __future__ import annotations

from collections.abc import Callable
from keyword import iskeyword
from typing import Any, NamedTuple

from rosproto.codec.classes import message_class
from rosproto.codec.layout import FORMATS, RANGES_BY_CODE
from rosproto.codec.message import DynamicMessage, Message
from rosproto.errors import CodecError
from rosproto.msg.spec import Field, MessageSpec

Convert = Callable[[Any], Any]


class ConversionError(CodecError):
    """Values cannot be converted between two definitions of a type.

    Attributes:
        table: Both definitions side by side.
    """

    def __init__(self, message: str, *, type_name: str, field_path: str, table: str) -> None:
        super().__init__(f"{message}\n{table}", type_name=type_name, field_path=field_path)
        self.table = table


class ValuesLost(CodecError):
    """The other side's definition lacks fields for some of the given values.

    Attributes:
        fields: Paths of those fields.
        theirs: The other side's class.
    """

    def __init__(self, fields: list[str], theirs: type[Message]) -> None:
        super().__init__(
            f"the other side's definition (md5sum {theirs._md5sum}) has no place for the values of "
            f"{', '.join(fields)}; leave them at their default, or use a peer of a newer revision",
            type_name=theirs._type,
            field_path=fields[0],
        )
        self.fields = fields
        self.theirs = theirs


class Conversion:
    """Turns messages of `source` into messages of `target`.

    Args:
        source: A message class.
        target: A class of the same type by another definition.

    Attributes:
        dropped: Paths of fields of `source` that `target` lacks.
        defaulted: Paths of fields of `target` that `source` lacks: they get their default.
        convert: message -> new message of `target`; the same as calling this object.

    Raises:
        ConversionError: A field changed its kind; both definitions are shown.
    """

    def __init__(self, source: type[Message], target: type[Message]) -> None:
        self.source = source
        self.target = target
        self.dropped: list[str] = []
        self.defaulted: list[str] = []
        self.convert = self._compiled(self._plan())
        self._default: Message | None = None

    def __repr__(self) -> str:
        return f"<Conversion {self.source._type} {self.source._md5sum[:4]} to {self.target._md5sum[:4]}>"

    def __call__(self, message: Message) -> DynamicMessage:
        """A new message of `target` with the values of `message`.

        Raises:
            CodecError: A value does not fit the target's width; names the field.
        """
        made: DynamicMessage = self.convert(message)
        return made

    def _compiled(self, steps: list[tuple[str, str, Convert | None]]) -> Convert:
        """Generate one function for all fields: a loop takes four times as long.

        The parser ensures that field names are identifiers, but they may be Python keywords.
        """
        scope: dict[str, Any] = {
            "new": object.__new__,
            "target": self.target,
            "get": getattr,
            "put": setattr,
        }
        lines = ["def convert(message):", " made = new(target)"]
        for i, (source_name, target_name, convert) in enumerate(steps):
            value = f"message.{source_name}"
            if iskeyword(source_name):
                value = f"get(message, {source_name!r})"
            if convert is not None:
                scope[f"convert_{i}"] = convert
                value = f"convert_{i}({value})"
            lines.append(_assignment(target_name, value))
        own = {name for _, name, _ in steps}
        missing = [field.name for field in self.target._spec.fields if field.name not in own]
        for i, name in enumerate(missing):
            # From a new message each time: a default may be a list, which the caller may change.
            scope[f"default_{i}"] = lambda name=name: getattr(self.target(), name)
            lines.append(_assignment(name, f"default_{i}()"))
        lines.append(" made._connection_header = get(message, '_connection_header', None)")
        lines.append(" return made")
        exec("\n".join(lines), scope)
        made: Convert = scope["convert"]
        return made

    def lost(self, message: Message) -> list[str]:
        """Paths of fields that `target` lacks and whose values differ from the default."""
        if not self.dropped:
            return []
        if self._default is None:
            self._default = self.source()
        return [
            path for path in self.dropped if _differs(message, self._default, path.split("."), self.source)
        ]

    def require_lossless(self, message: Message) -> None:
        """Raise ValuesLost when `lost(message)` is not empty."""
        lost = self.lost(message)
        if lost:
            raise ValuesLost(lost, self.target)

    def _plan(self) -> list[tuple[str, str, Convert | None]]:
        given = {field.name: field for field in self.source._spec.fields}
        steps: list[tuple[str, str, Convert | None]] = []
        used = set()
        for field in self.target._spec.fields:
            name = self._counterpart(field.name, given)
            if name is None:
                self.defaulted.append(field.name)
                continue
            used.add(name)
            steps.append((name, field.name, self._field(given[name], field)))
        self.dropped += [name for name in given if name not in used]
        if given and self.target._spec.fields and not used:
            # The result would contain only defaults, which look like values.
            raise ConversionError(
                "the two definitions share no field",
                type_name=self.target._type,
                field_path="",
                table=side_by_side(self.target._spec, self.source._spec, ("wanted", "given")),
            )
        return steps

    def _counterpart(self, name: str, given: dict[str, Field]) -> str | None:
        """The source's name of a target field: the same name or an alias."""
        if name in given:
            return name
        for library in (self.target._binding.library, self.source._binding.library):  # type: ignore[union-attr]
            for pair in library.field_aliases(self.target._type):
                if name in pair:
                    other = pair[1 - pair.index(name)]
                    if other in given:
                        return other
        return None

    def _field(self, given: Field, wanted: Field) -> Convert | None:
        old, new = given.type, wanted.type
        if old.is_array != new.is_array or (
            new.array_length is not None and old.array_length != new.array_length
        ):
            raise self._refuse(wanted, given)
        if old.is_builtin and new.is_builtin:
            return self._builtin(given, wanted)
        if old.base != new.base:
            raise self._refuse(wanted, given)
        return self._nested(wanted)

    def _nested(self, wanted: Field) -> Convert | None:
        base = wanted.type.base
        source, target = self.source._binding, self.target._binding
        assert source is not None
        assert target is not None
        source_class = message_class(base, source.library, value_style=source.value_style)
        target_class = message_class(base, target.library, value_style=target.value_style)
        if source_class is target_class:
            return None
        inner = Conversion(source_class, target_class)
        self.dropped += [f"{wanted.name}.{path}" for path in inner.dropped]
        self.defaulted += [f"{wanted.name}.{path}" for path in inner.defaulted]
        if wanted.type.is_array:
            return lambda items: [inner.convert(item) for item in items]
        return inner.convert

    def _builtin(self, given: Field, wanted: Field) -> Convert | None:
        old, new = given.type.base, wanted.type.base
        if FORMATS.get(old, old) == FORMATS.get(new, new):
            return None
        if old not in FORMATS or new not in FORMATS or "bool" in (old, new):
            raise self._refuse(wanted, given)
        check = _number(new, wanted.name, self.target._type)
        if wanted.type.is_array:
            return lambda items: [check(item) for item in _plain(items)]
        return check

    def _refuse(self, wanted: Field, given: Field) -> ConversionError:
        table = side_by_side(self.target._spec, self.source._spec, ("wanted", "given"))
        return ConversionError(
            f"is {given.type} on one side and {wanted.type} on the other: values cannot be "
            "converted; compare the definitions, and add the right one to your revisions folder",
            type_name=self.target._type,
            field_path=wanted.name,
            table=table,
        )


def _assignment(name: str, value: str) -> str:
    return f" put(made, {name!r}, {value})" if iskeyword(name) else f" made.{name} = {value}"


def _differs(given: object, default: object, path: list[str], cls: type[Message]) -> bool:
    """Whether a field differs from its default, in any element of the arrays on its path."""
    value, usual = getattr(given, path[0]), getattr(default, path[0])
    if len(path) == 1:
        return _unequal(value, usual)
    field = next(field for field in cls._spec.fields if field.name == path[0])
    inner = message_class(field.type.base, cls._binding.library, value_style=cls._binding.value_style)  # type: ignore[union-attr]
    blank = inner()
    return any(_differs(item, blank, path[1:], inner) for item in (value if field.type.is_array else [value]))


def _unequal(value: object, usual: object) -> bool:
    """`!=` for plain values and arrays."""
    if isinstance(value, (list, tuple)) or hasattr(value, "tolist"):
        return list(_plain(value)) != list(_plain(usual))
    return bool(value != usual)


def _plain(items: Any) -> Any:
    return items.tolist() if hasattr(items, "tolist") else items


def _number(kind: str, name: str, type_name: str) -> Convert:
    """Make a range check for `kind`; floats become integers only if they are whole."""
    code = FORMATS[kind]
    if code in "fd":
        return float
    low, high = RANGES_BY_CODE[code]

    def check(value: Any) -> int:
        # Neither NaN nor infinite: `int` refuses those with errors of its own.
        whole = int(value) if value == value and abs(value) != float("inf") else None
        if whole is None or whole != value or not low <= whole <= high:
            raise CodecError(
                f"{value!r} does not fit {kind} ({low} to {high}), the type of the field on the other side",
                type_name=type_name,
                field_path=name,
            )
        return whole

    return check


class Difference(NamedTuple):
    """One field that differs between two definitions.

    Attributes:
        name: The field.
        ours: Its type on our side; "" if missing.
        theirs: Its type on the other side; "" if missing.
    """

    name: str
    ours: str
    theirs: str


def differences(ours: MessageSpec, theirs: MessageSpec) -> list[Difference]:
    """Differing fields of two definitions, without moved ones (see `side_by_side`)."""
    left = {field.name: str(field.type) for field in ours.fields}
    right = {field.name: str(field.type) for field in theirs.fields}
    return [
        Difference(name, left.get(name, ""), right.get(name, ""))
        for name in dict.fromkeys([*left, *right])
        if left.get(name) != right.get(name)
    ]


def side_by_side(
    ours: MessageSpec, theirs: MessageSpec, titles: tuple[str, str] = ("here", "other side")
) -> str:
    """Both definitions as two columns of text; differing lines are marked."""
    rows = [("", *titles)]
    left, right = list(ours.fields), list(theirs.fields)
    for i in range(max(len(left), len(right))):
        mine = left[i] if i < len(left) else None
        other = right[i] if i < len(right) else None
        rows.append(("  " if mine == other else "! ", _words(mine), _words(other)))
    width = max(len(row[1]) for row in rows)
    return "\n".join(f"{mark:2}{mine:{width}} | {other}".rstrip() for mark, mine, other in rows)


def _words(field: Field | None) -> str:
    return f"{field.type} {field.name}" if field is not None else "-"
