"""Definitions: parsed .msg, .srv and .action texts, their md5sums, and libraries of them.

Start with `bundled()`, the definitions that ship with this package.
"""

from __future__ import annotations

from rosproto.msg.full_text import join_full_text, split_full_text
from rosproto.msg.full_text_library import DefinitionLimits, library_from_full_text
from rosproto.msg.library import DefinitionLibrary, bundled
from rosproto.msg.package_revisions import Revision
from rosproto.msg.parser import parse_action, parse_message, parse_service
from rosproto.msg.spec import (
    BUILTIN_TYPES,
    ActionSpec,
    Constant,
    Field,
    FieldType,
    MessageSpec,
    ServiceSpec,
)
from rosproto.msg.user_folder import environment_paths, learned_paths, revisions_folder

__all__ = [
    "BUILTIN_TYPES",
    "ActionSpec",
    "Constant",
    "DefinitionLibrary",
    "DefinitionLimits",
    "Field",
    "FieldType",
    "MessageSpec",
    "Revision",
    "ServiceSpec",
    "bundled",
    "environment_paths",
    "join_full_text",
    "learned_paths",
    "library_from_full_text",
    "parse_action",
    "parse_message",
    "parse_service",
    "revisions_folder",
    "split_full_text",
]
