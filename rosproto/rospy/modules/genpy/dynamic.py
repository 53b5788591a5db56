"""generate_dynamic: classes from a full definition text, as rosbag's readers use it."""

from rosproto.codec import define, message_class
from rosproto.errors import DefinitionError

from .message import FLAVOUR, MessageException


def generate_dynamic(core_type, msg_cat):
    """Classes of a type and of all types it uses, by "package/Type"."""
    try:
        library = define(core_type, msg_cat, value_style=FLAVOUR)._binding.library
        names = [core_type, *library.dependencies(core_type)]
        made = {name: message_class(name, library, value_style=FLAVOUR) for name in names}
    except DefinitionError as error:
        raise MessageException(str(error)) from None
    for name, cls in made.items():  # not the classes of the packages: `define` has libraries of its own
        cls.__name__ = cls.__qualname__ = "_" + name.replace("/", "__")
    return made
