"""Configurations as dicts and as dynamic_reconfigure/Config."""

from dynamic_reconfigure.msg import BoolParameter, Config, DoubleParameter, IntParameter, StrParameter


def encode_config(config, flat=True):
    """A Config from a dict."""
    message = Config()
    for name, value in config.items():
        if isinstance(value, bool):
            message.bools.append(BoolParameter(name, value))
        elif isinstance(value, int):
            message.ints.append(IntParameter(name, value))
        elif isinstance(value, float):
            message.doubles.append(DoubleParameter(name, value))
        elif isinstance(value, str):
            message.strs.append(StrParameter(name, value))
    return message


def decode_config(msg, description=None):
    """A dict from a Config."""
    parameters = [*msg.bools, *msg.ints, *msg.strs, *msg.doubles]
    return {parameter.name: parameter.value for parameter in parameters}


def decode_description(msg):
    """A list of dicts, one for each parameter, from a ConfigDescription."""
    low, high, default = (decode_config(part) for part in (msg.min, msg.max, msg.dflt))
    return [
        {
            "name": one.name,
            "type": one.type,
            "level": one.level,
            "description": one.description,
            "edit_method": one.edit_method,
            "min": low.get(one.name),
            "max": high.get(one.name),
            "default": default.get(one.name),
        }
        for group in msg.groups
        for one in group.parameters
    ]
