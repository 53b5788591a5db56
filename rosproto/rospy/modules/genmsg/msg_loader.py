"""genmsg.msg_loader: definitions read into a table."""

import os

from rosproto.errors import DefinitionError
from rosproto.msg import parse_message
from rosproto.rospy.finder import library

from .base import EXT_MSG, EXT_SRV, InvalidMsgSpec
from .msgs import (
    DURATION,
    DURATION_MSG,
    HEADER,
    HEADER_FULL_NAME,
    TIME,
    TIME_MSG,
    Constant,
    MsgSpec,
    bare_msg_type,
    is_builtin,
    resolve_type,
)
from .names import package_resource_name
from .srvs import SrvSpec


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
        InvalidMsgSpec: It is not a definition.
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
    """Read the types that a message uses; returns those of its own fields."""
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
    """Read the types that a message or service uses."""
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
        """A table with time and duration."""
        made = MsgContext()
        load_msg_from_string(made, TIME_MSG, TIME)
        load_msg_from_string(made, DURATION_MSG, DURATION)
        return made

    def register(self, full_msg_type, msgspec):
        """Add a message."""
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
        """Where it was read; None when unknown."""
        return self._files.get(full_msg_type)

    def set_depends(self, full_msg_type, dependencies):
        """The types of its own fields."""
        self._depends[full_msg_type] = dependencies

    def get_depends(self, full_msg_type):
        """The types of its own fields; None when unknown."""
        return self._depends.get(full_msg_type)

    def get_all_depends(self, full_msg_type):
        """All types it uses, directly or not, in the order of the full text."""
        return [name for own in self._depends[full_msg_type] for name in (own, *self.get_all_depends(own))]
