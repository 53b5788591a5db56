"""genmsg.names: names of types."""

import re

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
