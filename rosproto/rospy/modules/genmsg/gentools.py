"""genmsg.gentools: md5sums and full texts."""

import hashlib

from .base import EXT_MSG, EXT_SRV, MsgGenerationException
from .msgs import bare_msg_type, is_builtin
from .srvs import SrvSpec


def compute_md5_text(msg_context, spec):
    """The text behind a message's md5sum: constants, then fields, with md5sums for message types."""
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
    """A message's text, followed by those of all types it uses, once each."""
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
