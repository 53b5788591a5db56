"""genmsg as far as programs import it: definitions as MsgSpec and SrvSpec, their md5sums and full texts.

Templates and generators for other languages are not here. Types that a search path does not name are taken
from the definitions of this program (the bundled ones and those of --msg-path). What ROS has in submodules
(genmsg.msgs, genmsg.msg_loader ...) is all here, and their names lead here.
"""

import hashlib
import os
import re
import sys

from rosproto.errors import DefinitionError
from rosproto.msg import parse_message
from rosproto.rospy.definitions import library

for _part in ("base", "gentools", "msg_loader", "msgs", "names", "srvs"):
    sys.modules["%s.%s" % (__name__, _part)] = globals()[_part] = sys.modules[__name__]


SEP = "/"
MSG_DIR, SRV_DIR = "msg", "srv"
EXT_MSG, EXT_SRV = ".msg", ".srv"


class InvalidMsgSpec(Exception):
    """A definition is wrong."""


class MsgGenerationException(Exception):
    """A file is no definition."""


PRN_SEPARATOR = "/"
_NAME, _BASE = re.compile(r"[A-Za-z][\w/]*", re.ASCII), re.compile(r"[A-Za-z]\w*", re.ASCII)


def resource_name(res_pkg_name, name, my_pkg=None):
    """ "package/Type", or "Type" inside that package."""
    return name if not res_pkg_name or res_pkg_name == my_pkg else "%s/%s" % (res_pkg_name, name)


def resource_name_base(name):
    """ "Type" of "package/Type"."""
    return name.rpartition("/")[2]


def resource_name_package(name):
    """ "package" of "package/Type", None without one."""
    return name.partition("/")[0] if "/" in name else None


def package_resource_name(name):
    """("package", "Type"); the package is empty without one."""
    if name.count("/") > 1:
        raise ValueError("invalid name [%s]" % name)
    package, _, base = name.rpartition("/")
    return package, base


def is_legal_resource_name(name):
    """Letters, digits, underscores and slashes, a letter first."""
    return name is not None and "//" not in name and bool(_NAME.fullmatch(name))


def is_legal_resource_base_name(name):
    """The same without slashes."""
    return name is not None and bool(_BASE.fullmatch(name))


HEADER, TIME, DURATION = "Header", "time", "duration"
HEADER_FULL_NAME = "std_msgs/Header"
TIME_MSG, DURATION_MSG = "uint32 secs\nuint32 nsecs", "int32 secs\nint32 nsecs"
PRIMITIVE_TYPES = (
    "int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64 string bool char byte".split()
)
BUILTIN_TYPES = [*PRIMITIVE_TYPES, TIME, DURATION]


def is_header_type(msg_type):
    """True for the header, by any of its names."""
    return msg_type in (HEADER, HEADER_FULL_NAME, "roslib/Header")


def is_builtin(msg_type_name):
    """True when it is no message."""
    return msg_type_name in BUILTIN_TYPES


def bare_msg_type(msg_type):
    """Without the brackets of an array."""
    return None if msg_type is None else msg_type.partition("[")[0]


def resolve_type(msg_type, package_context):
    """With its package."""
    bare = bare_msg_type(msg_type)
    if bare == HEADER:
        return HEADER_FULL_NAME
    return msg_type if bare in BUILTIN_TYPES or "/" in msg_type else "%s/%s" % (package_context, msg_type)


def parse_type(msg_type):
    """(type of one, whether it is an array, its fixed length or None)."""
    if not msg_type:
        raise ValueError("Invalid empty type")
    base, bracket, length = msg_type.partition("[")
    if "[" in length:
        raise ValueError("Currently only support 1-dimensional array types: %s" % msg_type)
    if length in ("", "]"):
        return base, bool(bracket), None
    try:
        return base, True, int(length[:-1])
    except ValueError:
        raise ValueError("Invalid array dimension: [%s]" % length[:-1]) from None


def is_valid_msg_type(x):
    """True for the spelling of a type."""
    if not x or x != x.strip() or not is_legal_resource_name(bare_msg_type(x)):
        return False
    brackets = x[len(bare_msg_type(x)) :]
    return not brackets or (
        all(not number or number.isdigit() for number in brackets.strip("[]").split("]["))
        and brackets[0] + brackets[-1] == "[]"
    )


def is_valid_constant_type(x):
    """True for a type that constants may have."""
    return x in PRIMITIVE_TYPES


def is_valid_msg_field_name(x):
    """True for the spelling of a field's name."""
    return is_legal_resource_base_name(x)


class _Equal:
    def __eq__(self, other):
        return type(other) is type(self) and vars(self) == vars(other)

    __hash__ = object.__hash__


class Constant(_Equal):
    """A constant: `val` as Python has it, `val_text` as it is written."""

    def __init__(self, type_, name, val, val_text):
        if any(part is None for part in (type_, name, val, val_text)):
            raise ValueError("Constant must have non-None parameters")
        self.type, self.name, self.val, self.val_text = type_, name.strip(), val, val_text

    def __repr__(self):
        return "%s %s=%s" % (self.type, self.name, self.val)


class Field(_Equal):
    """A field: its type with brackets, and taken apart."""

    def __init__(self, name, type):
        self.name, self.type = name, type
        self.base_type, self.is_array, self.array_len = parse_type(type)
        self.is_header = is_header_type(type)
        self.is_builtin = is_builtin(self.base_type)

    def __repr__(self):
        return "[%s, %s, %s, %s, %s]" % (
            self.name, self.type, self.base_type, self.is_array, self.array_len
        )  # fmt: skip


class MsgSpec(_Equal):
    """A message: `types` and `names` of its fields, its constants, its text."""

    def __init__(self, types, names, constants, text, full_name, package="", short_name=""):
        if len(set(names)) != len(names):
            raise InvalidMsgSpec("Duplicate field names in message: %s" % names)
        own_package, own_name = package_resource_name(full_name)
        self.types, self.names, self.constants, self.text = types, names, constants, text
        self.full_name, self.package, self.short_name = (
            full_name,
            package or own_package,
            short_name or own_name,
        )
        self.header_present = bool(types) and (types[0], names[0]) == (HEADER_FULL_NAME, "header")
        try:
            self._parsed_fields = [Field(name, type_) for name, type_ in zip(names, types)]
        except ValueError as error:
            raise InvalidMsgSpec("invalid field: %s" % error) from None

    def fields(self):
        """[(type, name)]."""
        return list(zip(self.types, self.names))

    def parsed_fields(self):
        """As Field."""
        return self._parsed_fields

    def has_header(self):
        """True when the first field is `Header header`."""
        return self.header_present

    def __repr__(self):
        parts = [self.constants] if self.constants else []
        return "MsgSpec[%s]" % ", ".join(map(repr, [*parts, self.types, self.names]))

    def __str__(self):
        return self.text


class SrvSpec(_Equal):
    """A service: `request` and `response` are MsgSpec."""

    def __init__(self, request, response, text, full_name="", short_name="", package=""):
        own_package, own_name = package_resource_name(full_name)
        self.request, self.response, self.text, self.full_name = request, response, text, full_name
        self.package, self.short_name = package or own_package, short_name or own_name

    def __repr__(self):
        return "SrvSpec[%r, %r]" % (self.request, self.response)


class MsgNotFound(Exception):
    """There is no such definition."""

    def __init__(self, message, base_type=None, package=None, search_path=None):
        super().__init__(message)
        self.base_type, self.package, self.search_path = base_type, package, search_path


def get_msg_file(package, base_type, search_path, ext=EXT_MSG):
    """The file of a type; `search_path` is {package: [folders]}."""
    if not isinstance(search_path, dict):
        raise ValueError("search_path must be a dictionary of {namespace: dirpath}")
    for folder in search_path.get(package, ()):
        path = os.path.join(folder, base_type + ext)
        if os.path.isfile(path):
            return path
    if package in search_path:
        where = "in package [%s] with paths [%s]" % (package, search_path[package])
    else:
        where = ": unknown package [%s] on search path [%s]" % (package, search_path)
    text = "Cannot locate message [%s]%s%s" % (base_type, "" if where[0] == ":" else " ", where)
    raise MsgNotFound(text, base_type, package, search_path)


def get_srv_file(package, base_type, search_path):
    """The same for a service."""
    return get_msg_file(package, base_type, search_path, EXT_SRV)


def _text(full_name, search_path, ext):
    """(text, its file or None)."""
    package, base = package_resource_name(full_name)
    try:
        path = get_msg_file(package, base, search_path, ext)
    except MsgNotFound:
        if package in search_path:
            raise
        try:
            known = library()
            return (known.message if ext == EXT_MSG else known.service)(full_name).text, None
        except DefinitionError:
            pass
        raise
    with open(path, encoding="utf-8") as file:
        return file.read(), path


def load_msg_by_type(msg_context, msg_type, search_path):
    """Read a message into the table."""
    msg_type = HEADER_FULL_NAME if msg_type == HEADER else msg_type
    text, path = _text(msg_type, search_path, EXT_MSG)
    spec = load_msg_from_string(msg_context, text, msg_type)
    msg_context.set_file(msg_type, path)
    return spec


def load_srv_by_type(msg_context, srv_type, search_path):
    """Read a service into the table."""
    text, path = _text(srv_type, search_path, EXT_SRV)
    return _with_file(msg_context, load_srv_from_string(msg_context, text, srv_type), path)


def _with_file(msg_context, spec, path):
    for half in (spec.request, spec.response):
        msg_context.set_file(half.full_name, path)
    return spec


def load_msg_from_string(msg_context, text, full_name):
    """Read a text into the table.

    Raises:
        InvalidMsgSpec: It is no definition.
    """
    package, base = package_resource_name(full_name)
    try:
        found = parse_message(text, "%s/%s" % (package or "none", base))
    except DefinitionError as error:
        raise InvalidMsgSpec(str(error)) from None
    spec = MsgSpec(
        [str(field.type) for field in found.fields],
        [field.name for field in found.fields],
        [Constant(one.type, one.name, one.value, one.text) for one in found.constants],
        text,
        full_name,
    )
    msg_context.register(full_name, spec)
    return spec


def load_msg_from_file(msg_context, file_path, full_name):
    """Read a file into the table."""
    with open(file_path, encoding="utf-8") as file:
        spec = load_msg_from_string(msg_context, file.read(), full_name)
    msg_context.set_file(full_name, file_path)
    return spec


def load_srv_from_string(msg_context, text, full_name):
    """Read a service's text into the table: its two messages."""
    lines = text.split("\n")
    cut = next((i for i, line in enumerate(lines) if line.startswith("---")), len(lines))
    halves = lines[:cut], [line for line in lines[cut:] if not line.startswith("---")]
    request, response = (
        load_msg_from_string(msg_context, "".join(line + "\n" for line in half), full_name + suffix)
        for half, suffix in zip(halves, ("Request", "Response"))
    )
    return SrvSpec(request, response, text, full_name)


def load_srv_from_file(msg_context, file_path, full_name):
    """Read a service's file into the table."""
    with open(file_path, encoding="utf-8") as file:
        return _with_file(msg_context, load_srv_from_string(msg_context, file.read(), full_name), file_path)


def load_msg_depends(msg_context, spec, search_path):
    """Read what a message is made of; the types of its own fields."""
    depends = []
    for type_ in spec.types:
        name = resolve_type(bare_msg_type(type_), spec.package)
        if is_builtin(name):
            continue
        known = msg_context.is_registered(name)
        used = msg_context.get_registered(name) if known else load_msg_by_type(msg_context, name, search_path)
        depends.append(name)
        if msg_context.get_depends(name) is None:
            load_msg_depends(msg_context, used, search_path)
    msg_context.set_depends(spec.full_name, depends)
    return list(depends)


def load_depends(msg_context, spec, msg_search_path):
    """Read what a message or service is made of."""
    halves = [spec.request, spec.response] if isinstance(spec, SrvSpec) else [spec]
    if not isinstance(halves[0], MsgSpec):
        raise ValueError("spec does not appear to be a message or service")
    return [name for half in halves for name in load_msg_depends(msg_context, half, msg_search_path)]


class MsgContext:
    """The table of messages that were read, by name."""

    def __init__(self):
        self._specs, self._files, self._depends = {}, {}, {}

    @staticmethod
    def create_default():
        """With time and duration in it."""
        made = MsgContext()
        load_msg_from_string(made, TIME_MSG, TIME)
        load_msg_from_string(made, DURATION_MSG, DURATION)
        return made

    def register(self, full_msg_type, msgspec):
        """Take a message."""
        self._specs[bare_msg_type(full_msg_type)] = msgspec

    def is_registered(self, full_msg_type):
        """True when it is there."""
        return bare_msg_type(full_msg_type) in self._specs

    def get_registered(self, full_msg_type):
        """A message; KeyError when it is not there."""
        return self._specs[bare_msg_type(full_msg_type)]

    def set_file(self, full_msg_type, file_path):
        """Where it was read."""
        self._files[full_msg_type] = file_path

    def get_file(self, full_msg_type):
        """Where it was read; None when nobody knows."""
        return self._files.get(full_msg_type)

    def set_depends(self, full_msg_type, dependencies):
        """The types of its own fields."""
        self._depends[full_msg_type] = dependencies

    def get_depends(self, full_msg_type):
        """The types of its own fields; None when nobody knows."""
        return self._depends.get(full_msg_type)

    def get_all_depends(self, full_msg_type):
        """And those of theirs, in the order of the full text."""
        return [name for own in self._depends[full_msg_type] for name in (own, *self.get_all_depends(own))]


def compute_md5_text(msg_context, spec):
    """What the md5sum of a message is made of: constants, then fields, md5sums in place of message types."""
    lines = ["%s %s=%s" % (one.type, one.name, one.val_text) for one in spec.constants]
    for type_, name in zip(spec.types, spec.names):
        bare = bare_msg_type(type_)
        known = type_ if is_builtin(bare) else compute_md5(msg_context, msg_context.get_registered(bare))
        lines.append("%s %s" % (known, name))
    return "\n".join(lines).strip()


def compute_md5(msg_context, spec):
    """md5sum of a message or service."""
    halves = (spec.request, spec.response) if isinstance(spec, SrvSpec) else (spec,)
    text = "".join(compute_md5_text(msg_context, half) for half in halves)
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()


compute_md5_v2 = compute_md5


def compute_full_text(msg_context, spec):
    """A message's text and those of all that it is made of, once each."""
    parts = [spec.text + "\n"]
    for name in dict.fromkeys(msg_context.get_all_depends(spec.full_name)):
        parts.append("%s\nMSG: %s\n%s\n" % ("=" * 80, name, msg_context.get_registered(name).text))
    return "".join(parts)[:-1]


def compute_full_type_name(package_name, file_name):
    """ "package/Type" of a file."""
    for extension in (EXT_MSG, EXT_SRV):
        if file_name.endswith(extension):
            return "%s/%s" % (package_name, file_name[: -len(extension)])
    raise MsgGenerationException("Processing file: '%s' - unknown file extension" % file_name)
