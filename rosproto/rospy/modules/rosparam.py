"""rosparam as far as programs import it: parameters, and YAML files of them."""

from contextlib import contextmanager

import rosgraph
import rosgraph.names

from rosproto.node.parameters import leaves
from rosproto.typed_values import angle_loader, parse_value


class RosParamException(Exception):
    """A parameter or file cannot be used."""


class RosParamIOException(RosParamException):
    """The master cannot be reached."""


@contextmanager
def _asking():
    try:
        yield get_param_server()
    except OSError:
        raise RosParamIOException("Unable to communicate with master!") from None


def get_param_server():
    """The master."""
    return rosgraph.Master("/rosparam")


def get_param(param):
    """Value of a parameter."""
    with _asking() as server:
        return server.getParam(param)


def set_param_raw(param, value, verbose=False):
    """Set a parameter to a Python value; those of a dict one by one, so that what else is there stays."""
    try:
        for name, leaf in leaves(param, value):
            with _asking() as server:
                server.setParam(name, leaf)
            if verbose:
                print("set parameter [%s] to [%s]" % (name, leaf))
    except ValueError:
        raise RosParamException(
            "YAML dictionaries must have string keys. Invalid dictionary is:\n%s" % value
        ) from None


def set_param(param, value, verbose=False):
    """Set a parameter to the value of a YAML text."""
    set_param_raw(param, _load(value), verbose)


def upload_params(ns, values, verbose=False):
    """Set all parameters of a dict below a namespace."""
    if ns == "/" and not isinstance(values, dict):
        raise RosParamException("global / can only be set to a dictionary")
    set_param_raw(ns, values, verbose)


def delete_param(param, verbose=False):
    """Delete a parameter; those of the root namespace, which stays."""
    with _asking() as server:
        server.setParam("/", {}) if param == "/" else server.deleteParam(param)


def list_params(ns):
    """Sorted names of the parameters below a namespace."""
    prefix = rosgraph.names.make_global_ns(ns)
    with _asking() as server:
        return sorted(name for name in server.getParamNames() if name.startswith(prefix))


def dump_params(filename, param, verbose=False):
    """Write a parameter or namespace to a YAML file."""
    from yaml import safe_dump

    with open(filename, "w", encoding="utf-8") as file:
        file.write(safe_dump(get_param(param)))


def _load(text):
    try:
        import yaml
    except ImportError:
        return parse_value(text)
    return yaml.load(text, angle_loader(yaml, _invalid))


def _invalid(unit, node):
    what = "degree value" if unit == "degrees" else "radian expression"
    return RosParamException("invalid %s: %s" % (what, node.value))


def load_str(text, filename="", default_namespace=None, verbose=False):
    """[(parameters, namespace)] of a YAML text."""
    try:
        import yaml
    except ImportError:
        raise RosParamException("YAML files need PyYAML: pip install PyYAML") from None
    space = default_namespace or rosgraph.names.get_ros_namespace()
    found = []
    for values in yaml.load_all(text, angle_loader(yaml, _invalid)):
        inner = values.pop("_ns", "") if isinstance(values, dict) else ""
        place = rosgraph.names.ns_join(space, inner) if inner else space
        found.append(({} if values is None else values, place))
    return found


def load_file(filename, default_namespace=None, verbose=False):
    """[(parameters, namespace)] of a YAML file."""
    try:
        with open(filename, encoding="utf-8") as file:
            return load_str(file.read(), filename, default_namespace, verbose)
    except OSError as error:
        raise RosParamException("file [%s] does not exist" % filename) from error
