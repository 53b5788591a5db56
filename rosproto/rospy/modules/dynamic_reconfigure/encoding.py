"""Configurations as dicts and as dynamic_reconfigure/Config; their parameters as a tree of groups."""

import copy

from dynamic_reconfigure.msg import (
    BoolParameter,
    DoubleParameter,
    Group,
    GroupState,
    IntParameter,
    ParamDescription,
    StrParameter,
)
from dynamic_reconfigure.msg import Config as ConfigMsg
from dynamic_reconfigure.msg import ConfigDescription as ConfigDescrMsg

_FIELDS = {bool: ("bools", BoolParameter), int: ("ints", IntParameter), str: ("strs", StrParameter)}
_FIELDS[float] = ("doubles", DoubleParameter)


class Config(dict):
    """A dict whose items are attributes too."""

    __getattr__, __setattr__ = dict.__getitem__, dict.__setitem__

    def __getstate__(self):
        return list(self.__dict__.items())

    def __setstate__(self, items):
        self.__dict__.update(items)

    def copy(self):
        """A shallow copy."""
        return Config(self)

    def __deepcopy__(self, memo):
        return type(self)({copy.deepcopy(key): copy.deepcopy(value) for key, value in self.items()})


def encode_config(config, flat=True):
    """A message from a dict; values of types other than the four that exist are left out."""
    message = ConfigMsg()
    for name, value in config.items():
        if type(value) in _FIELDS:
            field, cls = _FIELDS[type(value)]
            getattr(message, field).append(cls(name, value))
        elif type(value) is dict or isinstance(value, Config):
            message.groups.extend(
                [_state(value), *_states(value)] if flat else [_state(one) for one in value]
            )
    return message


def _state(group):
    return GroupState(group["name"], group["state"], group["id"], group["parent"])


def _states(group):
    for inner in group["groups"].values():
        yield from _states(inner)
        yield _state(inner)


def encode_description(descr):
    """A message from the module generated from a .cfg file."""
    return ConfigDescrMsg(
        groups=encode_groups(None, descr.config_description),
        max=encode_config(descr.max),
        min=encode_config(descr.min),
        dflt=encode_config(descr.defaults),
    )


def encode_groups(parent, group):
    """Messages of a group and of those in it."""
    parameters = [
        ParamDescription(one["name"], one["type"], one["level"], one["description"], one["edit_method"])
        for one in group["parameters"]
    ]
    message = Group(group["name"], group["type"], parameters, group["parent"], group["id"])
    return [message, *(inner for one in group["groups"] for inner in encode_groups(message, one))]


def group_dict(group):
    """A group without its parameters and subgroups."""
    return Config(
        {
            "id": group.id,
            "parent": group.parent,
            "name": group.name,
            "type": getattr(group, "type", ""),
            "state": getattr(group, "state", True),
            "groups": Config({}),
            "parameters": Config({}),
        }
    )


def get_tree(m, group=None):
    """The groups of a message below a group, or all of them below the default one."""
    if group is None:
        root = next(one for one in m.groups if one.id == 0)
        tree = group_dict(root)
        tree["groups"] = get_tree(m, root)
        return tree
    children = Config({})
    for one in m.groups:
        if one.id != 0 and one.parent == group.id:
            child = children[one.name] = group_dict(one)
            child["groups"] = get_tree(m, one)
    return children


def decode_description(msg):
    """The tree of groups, with a list of dicts for the parameters of each."""
    low, high, default = (decode_config(part) for part in (msg.min, msg.max, msg.dflt))
    parameters = {
        group.id: [
            {
                "name": one.name,
                "min": low.get(one.name),
                "max": high.get(one.name),
                "default": default.get(one.name),
                "type": one.type,
                "level": one.level,
                "description": one.description,
                "edit_method": one.edit_method,
            }
            for one in group.parameters
        ]
        for group in msg.groups
    }
    tree = get_tree(msg)

    def fill(group):
        group["parameters"] = parameters[group["id"]]
        for inner in group["groups"].values():
            fill(inner)

    fill(tree)
    return tree


def _values(msg):
    return Config([(one.name, one.value) for one in [*msg.bools, *msg.ints, *msg.strs, *msg.doubles]])


def decode_config(msg, description=None):
    """A dict from a message; with a description also its groups and what is in them."""
    return _decoded(msg, description, _add_values)


def initial_config(msg, description=None):
    """The dict that a server begins with: the groups come from the .cfg file's module."""
    return _decoded(msg, description, _add_described)


def _decoded(msg, description, add):
    config = _values(msg)
    if msg.groups and description is not None:
        config["groups"] = get_tree(msg)
        add(config["groups"], description, config)
    return config


def _add_values(group, description, config):
    for one in description["parameters"]:
        if one["name"] in config:
            group[one["name"]] = config[one["name"]]
    for inner in group["groups"].values():
        for described in description["groups"].values():
            if described["name"] == inner["name"]:
                _add_values(inner, described, config)


def _add_described(group, description, config):
    for one in description["parameters"]:
        group["parameters"][one["name"]] = config[one["name"]]
    for inner in group["groups"].values():
        for described in description["groups"]:
            if described["name"] == inner["name"]:
                inner["state"] = described["state"]
                _add_described(inner, described, config)


def extract_params(group):
    """The parameters of a group and of those in it."""
    inner = group["groups"]
    inner = inner.values() if isinstance(inner, dict) else inner
    return [*group["parameters"], *(one for group in inner for one in extract_params(group))]
