"""Message classes by name: made once per library and value style, cached in the library."""

from __future__ import annotations

import warnings
from threading import RLock
from typing import Any

from rosproto.bounded_cache import BoundedCache
from rosproto.codec.binding import Binding
from rosproto.codec.layout import attribute_name, check_field_name
from rosproto.codec.message import DynamicMessage, Message, MessageMeta, ServiceType
from rosproto.codec.value_style import ValueStyle, value_style_named
from rosproto.errors import DefinitionError
from rosproto.msg import DefinitionLibrary, bundled, library_from_full_text
from rosproto.msg.spec import MessageSpec

_lock = RLock()
_DEFINED_KEPT = 256
_DEFINED_CHARACTERS = 2 << 20  # of all texts; a class takes thirty times the memory of its text
_defined_since = 0  # characters of texts since the last collector run
_defined: BoundedCache[tuple[str, str, ValueStyle], type[DynamicMessage]] = BoundedCache(
    _DEFINED_KEPT, _DEFINED_CHARACTERS
)


def message_class(
    type: str | MessageSpec,
    library: DefinitionLibrary | None = None,
    *,
    value_style: str | ValueStyle = "numpy",
    flavour: str | ValueStyle | None = None,
) -> type[DynamicMessage]:
    """The class of a message type; the same object every time.

    Args:
        type: "package/Type" (an action's messages and a service's request and response too), or a parsed
            definition, which then need not be in the library.
        library: Where definitions come from; `rosproto.msg.bundled()` by default.
        value_style: "numpy", "rospy", or a `ValueStyle`.
        flavour: Deprecated: the former name of `value_style`.

    Raises:
        DefinitionError: There is no such type, or its definition is wrong. (Types it uses are looked up when
            the class is first used.)
    """
    return _message_class(
        type, bundled() if library is None else library, _chosen(value_style, flavour), "msg"
    )


def _chosen(value_style: str | ValueStyle, flavour: str | ValueStyle | None) -> ValueStyle:
    if flavour is None:
        return value_style_named(value_style)
    warnings.warn("flavour= is now value_style=", DeprecationWarning, stacklevel=3)
    return value_style_named(flavour)


def _message_class(
    type_: str | MessageSpec, library: DefinitionLibrary, value_style: ValueStyle, kind: str
) -> type[DynamicMessage]:
    name = type_ if isinstance(type_, str) else type_.name
    if not isinstance(type_, str) and not _has(library, type_):
        library = library.fork()
        library.add(type_)
    classes = _cache(library)
    key = "msg", "std_msgs/Header" if name == "Header" else name, value_style
    cls: type[DynamicMessage] | None = classes.get(key)
    # A definition that was given, not named, may be another one than that of the class known by this name.
    if cls is None or type_ not in (name, cls._spec):
        with _lock:
            cls = classes.get(key)  # another thread may have made it meanwhile
            if cls is None or type_ not in (name, cls._spec):
                cls = classes[key] = _make_class(library.message(name), library, value_style, kind)
    return cls


def _has(library: DefinitionLibrary, spec: MessageSpec) -> bool:
    try:
        return library.message(spec.name) == spec
    except DefinitionError:
        return False


def _cache(library: DefinitionLibrary) -> dict[Any, Any]:
    """The cache in the library, which thus lives as long as the classes."""
    cache: dict[Any, Any] = vars(library).setdefault("_classes", {})
    return cache


def _make_class(
    spec: MessageSpec, library: DefinitionLibrary, value_style: ValueStyle, kind: str
) -> type[DynamicMessage]:
    def class_for(name: str) -> type[DynamicMessage]:
        return cls if name == spec.name else _message_class(name, library, value_style, "msg")

    binding = Binding(spec, library, value_style, class_for)
    names = [field.name for field in spec.fields]
    for name in names:
        check_field_name(name, spec.name)
    package, _, base_name = spec.name.partition("/")
    namespace: dict[str, object] = {constant.name: constant.value for constant in spec.constants}
    for name in names:
        namespace.pop(name, None)
    namespace.update(
        __slots__=names,
        __module__=value_style.module.format(package=package, kind=kind),
        __qualname__=base_name,
        __doc__=_docstring(spec.text),
        _type=spec.name,
        _spec=spec,
        _has_header=spec.has_header,
        _names=frozenset(
            [
                *names,
                *(attribute_name(name, names) for name in names),
                *second_names(library, spec.name, names),
            ]
        ),
        _binding=binding,
        _fill=binding.stub("fill"),
        _encode=binding.stub("encode"),
        _decode=binding.stub("decode"),
    )
    cls: Any = MessageMeta(base_name, (value_style.base or Message,), namespace)
    for name in names:
        if attribute_name(name, names) != name:
            type.__setattr__(cls, attribute_name(name, names), cls.__dict__[name])
    for other, name in second_names(library, spec.name, names).items():
        type.__setattr__(cls, other, cls.__dict__[name])
    binding.cls = cls
    return cls  # type: ignore[no-any-return]


def _docstring(text: str) -> str:
    """The definition, for `help()`. Non-UTF-8 bytes are escaped."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def second_names(library: DefinitionLibrary, type_name: str, names: list[str]) -> dict[str, str]:
    """Aliases of the definition's fields: alias -> field."""
    pairs = library.field_aliases(type_name)
    both = [*pairs, *((field, other) for other, field in pairs)]
    return {other: field for other, field in both if field in names and other not in names}


def service_class(
    name: str,
    library: DefinitionLibrary | None = None,
    *,
    value_style: str | ValueStyle = "numpy",
    flavour: str | ValueStyle | None = None,
) -> type[ServiceType]:
    """The class of a service type, with `Request` and `Response`.

    Raises:
        DefinitionError: There is no such service, or its definition is wrong.
    """
    library = bundled() if library is None else library
    kind = _chosen(value_style, flavour)
    classes = _cache(library)
    key = ("srv", name, kind)
    with _lock:
        cls = classes.get(key)
        if cls is None:
            cls = classes[key] = _make_service(name, library, kind)
    return cls


def _make_service(name: str, library: DefinitionLibrary, value_style: ValueStyle) -> type[ServiceType]:
    spec = library.service(name)
    request = _message_class(spec.request.name, library, value_style, "srv")
    response = _message_class(spec.response.name, library, value_style, "srv")
    package, _, base_name = name.partition("/")
    return type(
        base_name,
        (ServiceType,),
        {
            "__module__": value_style.module.format(package=package, kind="srv"),
            "__doc__": _docstring(spec.text),
            "_type": name,
            "_md5sum": library.md5sum(name, kind="srv"),
            "Request": request,
            "Response": response,
            "_request_class": request,
            "_response_class": response,
        },
    )


def define(
    name: str,
    full_text: str,
    *,
    base: DefinitionLibrary | None = None,
    value_style: str | ValueStyle = "numpy",
    flavour: str | ValueStyle | None = None,
) -> type[DynamicMessage]:
    """Make a class from a full definition text, as in connection headers and bags.

    The text is untrusted: its size is limited (`rosproto.msg.DefinitionLimits`), and only checked identifiers
    reach generated code. Equal texts give the same class while cached: the last 256 texts, at most 2 MB in
    total.

    Args:
        name: "package/Type" of the first definition.
        full_text: Its definition, then "=" * 80, "MSG: package/Type" and the text for each type it uses.
        base: Library of types that the text does not define; none by default.
        value_style, flavour: As for `message_class`.

    Raises:
        DefinitionError: The text is wrong, incomplete or too large.
    """
    kind = _chosen(value_style, flavour)
    key = (name, full_text, kind)
    with _lock:
        cls = _defined.get(key) if base is None else None
        if cls is None:
            library = library_from_full_text(name, full_text, base=base)
            cls = _message_class(name, library, kind, "msg")
            assert cls._binding is not None
            _ = cls._binding.layout  # raises if a used type is missing
            if base is None:
                _defined.put(key, cls, len(full_text))
                _clear_away(len(full_text))
    return cls


def _clear_away(characters: int) -> None:
    """Collect unused classes once the total length of their texts is large.

    Classes are in reference cycles, and the collector counts objects, not bytes: it would keep hundreds of
    classes with texts of a megabyte each.
    """
    global _defined_since
    _defined_since += characters
    if _defined_since > 2 * _DEFINED_CHARACTERS:
        import gc

        _defined_since = 0
        gc.collect()


def pickled(message: Message) -> tuple[object, ...]:
    """Result of `__reduce__`: how to find the class in another process, and the values."""
    binding = message._binding
    assert binding is not None
    known = binding.library is bundled()
    text = None if known else message._full_text
    found = (binding.spec.name, message._md5sum, text, binding.value_style.name)
    return restore, found, message.__getstate__()


def restore(name: str, md5sum: str, full_text: str | None, value_style: str) -> Message:
    """An empty message for `pickle` to fill.

    Raises:
        DefinitionError: The bundled definition differs from the pickled one.
    """
    cls = (
        message_class(name, value_style=value_style)
        if full_text is None
        else define(name, full_text, value_style=value_style)
    )
    if cls._md5sum != md5sum:
        raise DefinitionError(
            f"{name} was pickled with md5sum {md5sum}, the definition here has {cls._md5sum}; "
            "unpickle with the version that pickled it"
        )
    message: Message = cls.__new__(cls)
    return message
